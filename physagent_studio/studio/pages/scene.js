// Scene: switches of the 3D view, things to select, and the bar over the view.

import { draw, h } from "./dom.js";
import { on, send } from "./wire.js";

const VIEWS = [["photo", "Photo"], ["front", "Front"], ["side", "Side"], ["top", "Top"]];

export function startScene(host, bar, banner) {
  let data = null;
  on("scene", (next) => {
    data = next;
    draw(host,
      h("div", { class: "head" }, "Show"),
      h("div", { class: "stack", style: "gap:5px" }, data.switches.map((one) => h("label", { class: "row" }, h("input", { type: "checkbox", checked: one.on, onchange: () => send({ do: "show", what: one.what, on: !one.on }) }), one.text))),
      h("div", { class: "head" }, "Things"),
      h("div", { class: "stack", style: "gap:2px" }, data.things.map((one) => h("button", { class: "b quiet row", type: "button", style: "text-align:left;width:100%", onclick: () => send({ do: "select", kind: one.kind, name: one.name }) }, h("span", { class: "grow" }, one.name.replaceAll("_", " ")), h("span", { class: "chip" }, one.material.replaceAll("_", " "))))),
      data.camera ? [h("div", { class: "head" }, "Camera"), h("button", { class: "link", type: "button", onclick: () => send({ do: "select", kind: "camera" }) }, data.camera.text)] : null,
      data.findings.length ? [h("div", { class: "head" }, "How well the scene matches the photo"), data.findings.map((one) => h("div", { class: "check" }, h("span", { class: `dot ${one.ok ? "ok" : "bad"}` }, one.ok ? "✓" : "✕"), h("span", {}, one.text)))] : null,
      data.flags.length ? [h("div", { class: "head" }, "Assumed"), data.flags.map((one) => h("p", { class: "muted" }, one))] : null);
    draw(bar,
      h("div", { class: "pill" }, VIEWS.map(([view, text]) => h("button", { type: "button", title: `${text} view`, onclick: () => send({ do: "look", view }) }, text)), h("button", { type: "button", title: "Frame the selection (F)", onclick: () => send({ do: "look", view: "selection" }) }, "Selection")),
      h("div", { class: "pill" }, [["ghosts", "Ghosts"], ["trails", "Paths"], ["forces", "Forces"], ["contacts", "Contacts"]].map(([what, text]) => {
        const one = data.switches.find((item) => item.what === what);
        return one ? h("button", { type: "button", "aria-pressed": String(one.on), onclick: () => send({ do: "show", what, on: !one.on }) }, text) : null;
      })));
  });
  on("run", (run) => draw(banner, run.busy ? h("div", { class: "pill" }, h("span", {}, `${run.busy.charAt(0).toUpperCase()}${run.busy.slice(1)}…`), h("button", { type: "button", onclick: () => send({ do: "cancel" }) }, "Cancel")) : null));
}
