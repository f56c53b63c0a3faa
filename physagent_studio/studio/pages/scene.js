// Scene: switches of the 3D view, things to select, and the bar over the view.

import { draw, h } from "./dom.js";
import { edit, on, send } from "./wire.js";

const VIEWS = [["photo", "Photo"], ["front", "Front"], ["side", "Side"], ["top", "Top"]];

// Things to build with, set down near the origin on the ground.
const NEW = [
  ["Ball", "objects", { shape: { kind: "sphere", radius: 0.1 }, position: [0, 1.5, 0.1], material: "rubber", source: "person" }],
  ["Box", "objects", { shape: { kind: "box", size: [0.2, 0.2, 0.2] }, position: [0.5, 1.5, 0.1], material: "wood", source: "person" }],
  ["Cylinder", "objects", { shape: { kind: "cylinder", radius: 0.08, height: 0.3 }, position: [-0.5, 1.5, 0.15], material: "wood", source: "person" }],
  ["Table", "supports", { shape: { kind: "box", position: [0, 2, 0.2], size: [1, 0.6, 0.4] }, source: "person" }],
  ["Ramp", "supports", { shape: { kind: "ramp", toe: [-0.4, 1.5, 0], yaw: 3.1416, run: 0.8, rise: 0.3, width: 0.5 }, source: "person" }],
  ["Wall", "supports", { shape: { kind: "wall", point: [0, 3, 0], yaw: -1.5708 }, source: "person" }],
  ["Ground", "supports", { shape: { kind: "floor", height: 0 }, source: "person" }],
];

export function startScene(host, bar, banner) {
  let data = null;
  const add = (list, text, item) => {
    const stem = { Ground: "floor" }[text] || text.toLowerCase();
    const known = new Set(data.things.map((one) => one.name));
    let name = stem;
    for (let count = 2; known.has(name); count += 1) name = `${stem}_${count}`;
    // Side by side rather than into each other.
    const shift = data.things.filter((one) => one.kind === "object").length * 0.3;
    const placed = list === "objects" ? { ...item, position: [Math.round((item.position[0] + shift) * 100) / 100, item.position[1], item.position[2]] } : item;
    if (edit([{ op: "add", path: `scene.${list}`, item: { name, ...placed } }], `added ${name}`)) send({ do: "select", kind: list === "objects" ? "object" : "support", name });
  };
  on("scene", (next) => {
    data = next;
    draw(host,
      h("div", { class: "head" }, "Show"),
      h("div", { class: "stack", style: "gap:5px" }, data.switches.map((one) => h("label", { class: "row" }, h("input", { type: "checkbox", checked: one.on, onchange: () => send({ do: "show", what: one.what, on: !one.on }) }), one.text))),
      h("div", { class: "head" }, "Things"),
      h("div", { class: "stack", style: "gap:2px" }, data.things.map((one) => h("button", { class: "b quiet row", type: "button", style: "text-align:left;width:100%", onclick: () => send({ do: "select", kind: one.kind, name: one.name }) }, h("span", { class: "grow" }, one.name.replaceAll("_", " ")), h("span", { class: "chip" }, one.material.replaceAll("_", " "))))),
      data.readOnly ? null : [h("div", { class: "head" }, "Add"), h("div", { class: "row wrap", style: "gap:4px" }, NEW.map(([text, list, item]) => h("button", { class: "b small", type: "button", onclick: () => add(list, text, item) }, text)))],
      data.camera ? [h("div", { class: "head" }, "Camera"), h("button", { class: "link", type: "button", onclick: () => send({ do: "select", kind: "camera" }) }, data.camera.text)] : null,
      data.findings.length ? [h("div", { class: "head" }, "How well the scene matches the photo"), data.findings.map((one) => h("div", { class: "check" }, h("span", { class: `dot ${one.ok ? "ok" : "bad"}` }, one.ok ? "✓" : "✕"), h("span", {}, one.text)))] : null,
      data.flags.length ? [h("div", { class: "head" }, "Assumed"), data.flags.map((one) => h("p", { class: "muted" }, one))] : null);
    draw(bar,
      h("div", { class: "pill" }, VIEWS.map(([view, text]) => h("button", { type: "button", title: `${text} view`, onclick: () => send({ do: "look", view }) }, text)), h("button", { type: "button", title: "Frame the selection (F)", onclick: () => send({ do: "look", view: "selection" }) }, "Selection")),
      h("div", { class: "pill" }, [["ghosts", "Ghosts"], ["trails", "Paths"], ["forces", "Forces"], ["contacts", "Contacts"], ["gizmo", "Move"]].map(([what, text]) => {
        const one = data.switches.find((item) => item.what === what);
        return one ? h("button", { type: "button", "aria-pressed": String(one.on), onclick: () => send({ do: "show", what, on: !one.on }) }, text) : null;
      })));
  });
  on("run", (run) => draw(banner, run.busy ? h("div", { class: "pill" }, h("span", {}, `${run.busy.charAt(0).toUpperCase()}${run.busy.slice(1)}…`), h("button", { type: "button", onclick: () => send({ do: "cancel" }) }, "Cancel")) : null));
}
