// Photo: the picture with its objects outlined, and the sentence.

import { draw, h } from "./dom.js";
import { on, send } from "./wire.js";

export function startPhoto(host) {
  let data = null, head = null;
  const show = () => {
    if (!data) return;
    const chosen = head ? head.selection.name : "";
    draw(host,
      data.prompt ? h("p", { style: "margin-bottom:10px" }, "“", data.prompt, "”") : null,
      data.image ? h("div", { class: "photo" },
        h("img", { src: data.image, alt: "The photo", width: data.size[0], height: data.size[1], style: "height:auto" }),
        h("svg", { viewBox: `0 0 ${data.size[0]} ${data.size[1]}`, preserveAspectRatio: "none" },
          data.objects.map((one) => one.outline.map((points) => h("polygon", { class: one.name === chosen ? "on" : "", points: points.map((p) => p.join(",")).join(" "), onclick: () => send({ do: "select", kind: "object", name: one.name }) }, h("title", {}, one.name)))),
          [...data.objects, ...data.supports].map((one) => one.clicks.map(([x, y, inside]) => h("circle", { cx: x, cy: y, r: data.size[0] / 160, fill: inside ? "#2f6fed" : "#d9482b", stroke: "#fff", "stroke-width": data.size[0] / 640, "pointer-events": "none" }))))) : h("p", { class: "muted" }, "This program has no photo."),
      data.image ? h("div", { class: "row wrap", style: "margin-top:8px;gap:4px" }, data.objects.map((one) => h("button", { class: "b small", type: "button", "aria-pressed": String(one.name === chosen), onclick: () => send({ do: "select", kind: "object", name: one.name }) }, one.name.replaceAll("_", " ")))) : null);
  };
  on("photo", (next) => { data = next; show(); });
  on("playhead", (next) => {
    const changed = !head || head.selection.name !== next.selection.name;
    head = next;
    if (changed) show();
  });
}
