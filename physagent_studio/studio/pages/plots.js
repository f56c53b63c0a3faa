// Plots: height, speed and energy over the clip; click or drag to move the playhead.

import { draw, h } from "./dom.js";
import { on, send } from "./wire.js";

export function startPlots(host) {
  let data = null, head = null;
  const off = new Set();
  const tint = (at) => `rgb(${data.colours[at].join(" ")})`;
  const W = 300, H = 120, L = 46, B = 16;

  function show() {
    if (!data) return;
    if (!data.plots.length) return draw(host, h("p", { class: "muted" }, "Curves appear here once something has run."));
    draw(host,
      h("div", { class: "row wrap", style: "gap:4px 10px;margin-bottom:8px" }, data.objects.map((name, at) => h("label", { class: "row", style: "gap:5px", title: "Draw its curves, or leave them out" }, h("input", { type: "checkbox", checked: !off.has(name), onchange: () => { if (off.has(name)) off.delete(name); else off.add(name); show(); } }), h("span", { class: "swatch", style: `background:${tint(at)}` }), h("span", {}, name.replaceAll("_", " "))))),
      data.plots.map(plot),
      h("p", { class: "faint" }, data.plots.some((one) => one.other) ? `Dashed: ${data.dashed}.` : ""));
    cursor();
  }

  function plot(one) {
    const drawn = one.series.map((line, at) => ({ line, other: one.other && one.other[at], at })).filter(({ at }) => !off.has(data.objects[at]));
    const all = drawn.flatMap(({ line, other }) => [...line, ...(other || [])]);
    let low = Math.min(...all, 0), high = Math.max(...all, low + 1e-6);
    if (!all.length) [low, high] = [0, 1];
    const x = (step) => L + (step / data.steps) * (W - L - 4), y = (v) => H - B - ((v - low) / (high - low)) * (H - B - 6);
    const path = (line) => line.map((v, i) => `${i ? "L" : "M"}${x(data.at[i]).toFixed(1)} ${y(v).toFixed(1)}`).join("");
    const jump = (event) => {
      const box = event.currentTarget.getBoundingClientRect();
      const share = ((event.clientX - box.left) / box.width * W - L) / (W - L - 4);
      send({ do: "scrub", frame: Math.round(Math.max(0, Math.min(1, share)) * (head ? head.frames - 1 : 80)) });
    };
    return h("div", { class: "plot" }, h("div", { class: "head", style: "margin:8px 0 2px" }, one.title, h("span", { class: "push faint" }, one.unit)),
      h("svg", { viewBox: `0 0 ${W} ${H}`, style: "cursor:crosshair;touch-action:none", "aria-label": one.title, onpointerdown: (e) => { e.currentTarget.setPointerCapture(e.pointerId); e.currentTarget.onpointermove = jump; jump(e); }, onpointerup: (e) => { e.currentTarget.onpointermove = null; } },
        [low, (low + high) / 2, high].map((v) => [h("line", { x1: L, x2: W - 4, y1: y(v), y2: y(v), stroke: "var(--line)" }), h("text", { x: L - 5, y: y(v) + 3.500, "text-anchor": "end" }, nice(v, high - low))]),
        drawn.map(({ line, other, at }) => [other ? h("path", { d: path(other), fill: "none", stroke: tint(at), "stroke-width": 1.200, "stroke-dasharray": "4 3", opacity: 0.7 }) : null, h("path", { d: path(line), fill: "none", stroke: tint(at), "stroke-width": 1.800 })]),
        h("line", { class: "cursor", y1: 2, y2: H - B, stroke: "var(--accent)", "stroke-width": 1.500 })));
  }

  function cursor() {
    if (!head || !data || !data.steps) return;
    const at = L + (head.step / data.steps) * (W - L - 4);
    for (const line of host.querySelectorAll(".cursor")) { line.setAttribute("x1", at); line.setAttribute("x2", at); }
  }

  on("plots", (next) => { data = next; show(); });
  on("playhead", (next) => { head = next; cursor(); });
}

// Two figures of the range; what is nothing beside it is nothing.
const nice = (value, range) => figure(value, range).replace("-", "−");
const figure = (value, range) => (Math.abs(value) < range * 5e-3 ? "0" : Math.abs(value) >= 100 ? value.toFixed(0) : Number(value.toPrecision(2)).toString());
