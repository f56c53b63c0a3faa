// An object from a mesh file: choose it, see what is in it, say how large it is, set it down.

import { button, draw, dropping, h, keepInside } from "./dom.js";
import { on, send, value } from "./wire.js";

const KINDS = ".glb,.obj,.ply,.stl";
const MAX_FILE = 16 * 2 ** 20;

export function startMeshFile(host) {
  let ticket = 0, open = false, from = null;
  let file = "", problem = "", found = null, reading = false;
  let name = "", longest = "", up = "z";

  function close() {
    open = false;
    ticket += 1;
    draw(host);
    from?.focus?.({ preventScroll: true });
  }

  async function take(chosen) {
    if (!chosen) return;
    ticket += 1;
    const mine = ticket;
    file = chosen.name;
    found = null;
    problem = chosen.size > MAX_FILE ? `${file} has ${(chosen.size / 2 ** 20).toFixed(1)} MB; at most 16 are allowed.` : "";
    reading = !problem;
    show();
    if (problem) return;
    const bytes = new Uint8Array(await chosen.arrayBuffer());
    if (mine !== ticket) return;
    let text = "";
    for (let at = 0; at < bytes.length; at += 32768) text += String.fromCharCode(...bytes.subarray(at, at + 32768));
    if (!send({ do: "read_mesh", file, data: btoa(text), ticket })) { reading = false; show(); }
  }

  on("mesh", (answer) => {
    if (!open || answer.ticket !== ticket) return;
    reading = false;
    problem = answer.problem || "";
    found = answer.problem ? null : answer;
    if (found) {
      name = file.replace(/\.[^.]*$/, "").replace(/[^A-Za-z0-9_-]+/g, "_").replace(/^[_-]+|[_-]+$/g, "").slice(0, 56) || "mesh";
      longest = String(found.longest);
      up = found.up;
    }
    show();
    if (found) host.querySelector("[data-first]")?.select();
  });

  const metres = () => {
    const size = Number(longest.trim().replace(",", "."));
    return Number.isFinite(size) && size >= 0.001 && size <= 1000 ? size : null;
  };

  function add() {
    if (!found || metres() === null || !name.trim()) return;
    if (send({ do: "add_mesh", name: name.trim(), longest: metres(), up })) close();
  }

  const line = (text, field) => [h("div", { class: "label" }, text), field];
  const neat = (part) => Number(part.toPrecision(3));

  // Width × depth × height once it stands, in metres.
  function size() {
    const [x, y, z] = found.size, factor = metres() / Math.max(...found.size);
    return (up === "y" ? [x, z, y] : [x, y, z]).map((part) => neat(part * factor)).join(" × ");
  }

  function chooser() {
    return h("label", { class: `entry drop${found ? " small" : ""}`, ...dropping(take) },
      h("span", { class: "muted" }, h("b", {}, file ? "Choose another file" : "Choose a mesh file"), " · GLB, OBJ, PLY or STL, up to 16 MB"),
      h("input", { type: "file", accept: KINDS, "aria-label": "Mesh file", onchange: (e) => take(e.target.files[0]) }));
  }

  function facts() {
    const spot = value("scene")?.spot;
    return [
      h("p", {}, h("b", {}, file), h("span", { class: "muted" }, ` · ${found.faces} faces, ${found.size.join(" × ")} in the file`)),
      h("div", { class: "form" }, line("Name", h("input", { type: "text", value: name, "aria-label": "Name", oninput: (e) => { name = e.target.value; show(); } })),
      line("Longest edge", h("div", { class: "num-with-unit" }, h("input", { type: "text", inputmode: "decimal", "data-first": true, value: longest, "aria-label": "Longest edge", class: metres() === null ? "wrong" : "", oninput: (e) => { longest = e.target.value; show(); } }), h("span", { class: "unit" }, "m"))),
      line("Up in the file", h("select", { value: up, "aria-label": "Up in the file", onchange: (e) => { up = e.target.value; show(); } }, [["y", "y, as in most GLB and OBJ files"], ["z", "z, as in most STL and PLY files"]].map(([key, text]) => h("option", { value: key }, text))))),
      h("p", { class: "muted" }, metres() === null ? "Give a length from 0.001 to 1000 m." : `It will be ${size()} m, standing ${spot?.on ? `on ${spot.on.replaceAll("_", " ")}` : "at height 0"}.`),
    ];
  }

  function show() {
    if (!open) return;
    draw(host, h("div", { class: "shade", onpointerdown: (e) => { if (e.target === e.currentTarget) close(); }, onkeydown: (e) => { if (e.key === "Escape") { e.stopPropagation(); close(); } else keepInside(e); } },
      h("div", { class: "dialog narrow", role: "dialog", "aria-modal": "true", "aria-label": "Object from a mesh file" },
        h("header", {}, h("div", { class: "title grow" }, "Object from a mesh file"), button("Close", close, { class: "b quiet" })),
        h("form", { class: "body stack", onsubmit: (e) => { e.preventDefault(); add(); } },
          problem ? h("div", { class: "strip bad", role: "alert" }, problem) : null,
          reading ? h("p", { class: "muted" }, `Reading ${file}…`) : null,
          found ? facts() : null, chooser(),
          h("button", { type: "submit", hidden: true })),
        h("footer", {}, button("Add to the scene", add, { class: "b main", disabled: !found || metres() === null || !name.trim() })))));
  }

  return {
    open() {
      if (open) return;
      [open, from, file, problem, found, reading] = [true, document.activeElement, "", "", null, false];
      show();
      host.querySelector("input[type=file]").focus();
    },
  };
}
