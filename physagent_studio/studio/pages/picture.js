// Picture: what the 3D view shows now, as a PNG at a chosen size.

import { button, draw, h } from "./dom.js";

const SIZES = [[1280, 720], [1920, 1080], [2560, 1440], [3840, 2160], [1080, 1080]];
const MOST = 4096;
const host = document.body.appendChild(h("div", {}));
let size = [1920, 1080];
let problem = "";

export function openPicture() {
  problem = "";
  show();
  host.querySelector("input")?.focus();
}

const close = () => draw(host);

function show() {
  const put = (at) => (e) => { size[at] = Math.max(64, Math.min(MOST, Math.round(Number(e.target.value)) || size[at])); show(); };
  draw(host, h("div", { class: "shade", onpointerdown: (e) => { if (e.target === e.currentTarget) close(); }, onkeydown: (e) => { if (e.key === "Escape") { e.stopPropagation(); close(); } } },
    h("div", { class: "dialog narrow", role: "dialog", "aria-modal": "true", "aria-label": "Picture of the scene" },
      h("header", {}, h("div", { class: "title grow" }, "Picture of the scene"), button("Close", close, { class: "b quiet" })),
      h("div", { class: "body stack" },
        h("p", { class: "muted" }, "What the scene shows now, without the panels."),
        problem ? h("div", { class: "strip bad" }, problem) : null,
        h("div", { class: "row" }, h("input", { type: "number", min: 64, max: MOST, value: String(size[0]), "aria-label": "Width in pixels", onchange: put(0) }), "×", h("input", { type: "number", min: 64, max: MOST, value: String(size[1]), "aria-label": "Height in pixels", onchange: put(1) }), h("span", { class: "muted" }, "pixels")),
        h("div", { class: "row wrap", style: "gap:4px" }, SIZES.map((one) => button(`${one[0]} × ${one[1]}`, () => { size = [...one]; show(); }, { class: "b small", "aria-pressed": String(one[0] === size[0] && one[1] === size[1]) })))),
      h("footer", {}, button("Save the picture", save, { class: "b main" })))));
}

async function save() {
  const view = document.getElementById("viewer").contentWindow;
  try {
    const blob = await view.studioPicture(...size);
    const link = h("a", { href: URL.createObjectURL(blob), download: `scene-${size[0]}x${size[1]}.png` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    close();
  } catch {
    problem = "The scene is not drawn yet; try again in a moment.";
    show();
  }
}
