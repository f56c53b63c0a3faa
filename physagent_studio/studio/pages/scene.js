// Scene: switches of the 3D view, things to select, and the bar over the view.

import { draw, h } from "./dom.js";
import { drawingChoice } from "./drawing.js";
import { edit, on, send } from "./wire.js";

const TIPS = {
  photo: "As the photo was taken (0)", front: "From the front", side: "From the right", top: "From above (T)",
  ghosts: "Where things go in other rounds, as shades (G)", trails: "The ways that things take, as lines", forces: "What pushes, and how fast things go (V)",
  supports: "The ground, tables and ramps", labels: "What things are called", centres: "Where the weight of a thing is as if in one point",
  collisions: "The shapes that the physics works with, as wire", frustum: "Where the photo was taken from", gravity: "Which way things fall", axes: "Right, away from the camera, up",
  clean: "While it plays, nothing is drawn over the picture: no grid, names, paths or ghosts",
  contacts: "Where things touch, and how hard (C)", gizmo: "Handles to move, turn and scale what is selected (M)",
};
const VIEWS = [["photo", "Photo"], ["front", "Front"], ["side", "Side"], ["top", "Top"]];

// Things to build with, of the size `m` of what is there already; [x, y, z] from the free spot on.
const NEW = [
  ["Ball", "objects", (m, at) => ({ shape: { kind: "sphere", radius: m(0.5) }, position: at(0, 0, 0.5), material: "rubber" })],
  ["Box", "objects", (m, at) => ({ shape: { kind: "box", size: [m(1), m(1), m(1)] }, position: at(0, 0, 0.5), material: "wood" })],
  ["Cylinder", "objects", (m, at) => ({ shape: { kind: "cylinder", radius: m(0.4), height: m(1.5) }, position: at(0, 0, 0.75), material: "wood" })],
  ["Ring", "objects", (m, at) => ({ shape: { kind: "torus", radius: m(0.8), tube: m(0.25) }, position: at(0.6, 0, 0.25), material: "rubber" })],
  ["Capsule", "objects", (m, at) => ({ shape: { kind: "capsule", radius: m(0.3), height: m(1.5) }, position: at(0, 0, 0.75), material: "plastic" })],
  ["Cone", "objects", (m, at) => ({ shape: { kind: "frustum", bottom_radius: m(0.5), top_radius: m(0.1), height: m(1) }, position: at(0, 0, 0.36), material: "plastic" })],
  ["Cup", "objects", (m, at) => ({ shape: { kind: "frustum", bottom_radius: m(0.4), top_radius: m(0.55), height: m(1), wall: m(0.06) }, position: at(0, 0, 0.552), material: "ceramic" })],
  ["Cloth", "objects", (m, at) => ({ shape: { kind: "box", size: [m(2), m(2), m(0.04)] }, position: at(0.6, 0, 2), material: "fabric", support: "air", body: { kind: "cloth" } })],
  ["Table", "supports", (m, at) => ({ shape: { kind: "box", position: at(0, 2.5, 1), size: [m(5), m(3), m(2)] } })],
  ["Ramp", "supports", (m, at) => ({ shape: { kind: "ramp", toe: at(0.5, 0, 0), yaw: 0, run: m(4), rise: m(1.5), width: m(2.5) } })],
  ["Stairs", "supports", (m, at) => ({ shape: { kind: "ramp", toe: at(0.5, 0, 0), yaw: 0, run: m(3), rise: m(2), width: m(3), plateau: m(1.5), steps: 4 } })],
  ["Wall", "supports", (m, at) => ({ shape: { kind: "wall", point: at(0, 6, 0), yaw: -1.5708 } })],
  ["Ground", "supports", (m, at) => ({ shape: { kind: "floor", height: at(0, 0, 0)[2] } })],
];

export function startScene(host, bar, banner, meshFile, inspect) {
  let data = null;
  let glass = false;
  const see = () => { document.getElementById("viewer").contentWindow?.studioGlass?.(glass); };
  document.getElementById("viewer").addEventListener("load", see);
  // What was added and is not in the scene yet: quick clicks come before it.
  const given = new Set();
  const add = (list, text, make) => {
    const stem = { Ground: "floor" }[text] || text.toLowerCase();
    const known = new Set([...data.things.map((one) => one.name), ...given]);
    let name = stem;
    for (let count = 2; known.has(name); count += 1) name = `${stem}_${count}`;
    const { x: free, y, ground, on: under, size } = list === "objects" ? data.spot : data.groundSpot, neat = (value) => Number(value.toPrecision(4));
    const x = free + given.size * 1.5 * size;
    given.add(name);
    const item = make((part) => neat(part * size), (a, b, c) => [neat(x + a * size), neat(y + b * size), neat(ground + c * size)]);
    if (edit([{ op: "add", path: `scene.${list}`, item: { name, source: "person", ...(list === "objects" && under ? { support: under } : {}), ...item } }], `added ${name}`)) send({ do: "select", kind: list === "objects" ? "object" : "support", name });
  };
  // What does not match stands open, the rest is folded away.
  function matches() {
    const line = (one) => h("div", { class: "check" }, h("span", { class: `dot ${one.ok ? "ok" : "bad"}` }, one.ok ? "✓" : "✕"), h("span", {}, one.text));
    const good = data.findings.filter((one) => one.ok);
    return [h("div", { class: "head" }, "How well the scene matches the photo"), data.findings.filter((one) => !one.ok).map(line),
      h("details", {}, h("summary", { class: "muted" }, `${good.length} of ${data.findings.length} checks hold`), good.map(line))];
  }

  on("scene", (next) => {
    data = next;
    for (const one of data.things) given.delete(one.name);
    draw(host,
      h("div", { class: "head" }, "Show"),
      h("div", { class: "stack", style: "gap:5px" }, data.switches.map((one) => h("label", { class: "row", title: TIPS[one.what] }, h("input", { type: "checkbox", checked: one.on, onchange: () => send({ do: "show", what: one.what, on: !one.on }) }), one.text)),
        h("label", { class: "row", title: "Things are drawn so that one sees through them, on this page alone" }, h("input", { type: "checkbox", checked: glass, onchange: (e) => { glass = e.target.checked; see(); } }), "See-through things"), drawingChoice()),
      h("div", { class: "head" }, "Things"),
      h("div", { class: "stack", style: "gap:2px" }, data.things.map((one) => h("div", { class: "row", style: "gap:2px", key: `${one.kind} ${one.name}` }, h("button", { class: "b quiet row grow", type: "button", style: "text-align:left", title: "Show its numbers", onclick: () => { send({ do: "select", kind: one.kind, name: one.name }); inspect(); } }, h("span", { class: one.hidden ? "grow faint" : "grow" }, one.name.replaceAll("_", " ")), h("span", { class: "chip" }, one.material.replaceAll("_", " "))),
        one.kind === "object" ? [h("button", { class: "b quiet small", type: "button", "aria-pressed": String(one.hidden), title: one.hidden ? "Show it again" : "Do not draw it", onclick: () => send({ do: "hide", name: one.name }) }, one.hidden ? "Show" : "Hide"), h("button", { class: "b quiet small", type: "button", title: "Draw only this one; again: all of them", onclick: () => send({ do: "hide", name: one.name, how: "only" }) }, "Only")] : null))),
      data.readOnly ? null : [h("div", { class: "head" }, "Add"), h("div", { class: "row wrap", style: "gap:4px" }, NEW.map(([text, list, item]) => h("button", { class: "b small", type: "button", onclick: () => add(list, text, item) }, text)), h("button", { class: "b small", type: "button", title: "An object from a GLB, OBJ, PLY or STL file", onclick: meshFile.open }, "Mesh file…"))],
      data.camera ? [h("div", { class: "head" }, "Camera"), h("button", { class: "link", type: "button", onclick: () => { send({ do: "select", kind: "camera" }); inspect(); } }, data.camera.text)] : null,
      data.findings.length ? matches() : null,
      data.learned.length ? [h("div", { class: "head" }, "Learned models"), data.learned.map((one) => h("p", { class: "muted" }, one))] : null,
      data.flags.length ? [h("div", { class: "head" }, "Assumed"), data.flags.map((one) => h("p", { class: "muted" }, one))] : null);
    draw(bar,
      h("div", { class: "pill" }, VIEWS.map(([view, text]) => h("button", { type: "button", title: TIPS[view], onclick: () => send({ do: "look", view }) }, text)), h("button", { type: "button", title: "Frame the selection (F)", onclick: () => send({ do: "look", view: "selection" }) }, "Selection")),
      h("div", { class: "pill" }, [["clean", "Clean"], ["ghosts", "Ghosts"], ["trails", "Paths"], ["forces", "Forces"], ["contacts", "Contacts"], ["gizmo", "Move"]].map(([what, text]) => {
        const one = data.switches.find((item) => item.what === what);
        return one ? h("button", { type: "button", title: TIPS[what], "aria-pressed": String(one.on), onclick: () => send({ do: "show", what, on: !one.on }) }, text) : null;
      })));
  });
  const additions = NEW.map(([text, list, item]) => [text, () => { if (data && !data.readOnly) add(list, text, item); }]);
  // While presenting the panel that says so is hidden.
  on("run", (run) => draw(banner, run.busy ? h("div", { class: "pill" }, h("span", {}, `${run.busy.charAt(0).toUpperCase()}${run.busy.slice(1)}…`)) : null));
  return { additions };
}
