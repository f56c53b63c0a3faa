// What lies over the photo: outlines, clicks, strokes, the horizon, a ramp, what is being made.

import { h } from "./dom.js";

const rgb = (colour) => `rgb(${colour.join(" ")})`;
// How far a line that is tilted by so many degrees has risen beside the photo's middle.
export const rise = (roll, x) => Math.tan((roll * Math.PI) / 180) * x;
const list = (points) => points.map((p) => p.join(",")).join(" ");

// Supports lie below the things on them, and show where they are pointed at or chosen.
export function outlines(data, chosen, state) {
  const made = state.pending;
  const supports = data.supports.filter((one) => one.path).map((one) =>
    h("g", { key: `on ${one.name}`, class: one.name === chosen ? "ph-support on" : "ph-support" },
      h("path", { class: "ph-area", "data-name": one.name, "data-kind": "support", d: one.area }, h("title", {}, one.name.replaceAll("_", " "))),
      h("path", { class: "ph-case", d: one.path }), h("path", { class: "ph-edge", d: one.path })));
  return [supports, data.objects.filter((one) => one.path && !(made && made.name === one.name && made.masks.length)).map((one) => {
    const on = one.name === chosen;
    return h("g", { key: one.name, class: made && !on ? "ph-dim" : "" },
      h("path", { class: "ph-case", d: one.path }),
      h("path", { class: on ? "ph-line on" : "ph-line", "data-name": one.name, "data-kind": "object", d: one.path, stroke: rgb(one.colour), fill: rgb(one.colour), "fill-opacity": on ? ".3" : ".12" }, h("title", {}, one.name.replaceAll("_", " "))));
  })];
}

export function marks(data, chosen, state, unit) {
  const made = state.pending;
  const shown = made ? made.grounding : [...data.objects, ...data.supports].find((one) => one.name === chosen)?.grounding;
  const others = [...data.objects, ...data.supports].filter((one) => one.name !== (made?.name || chosen));
  // Clicks inside other things count as outside of this one; they are shown once.
  const taken = new Set(others.flatMap((one) => one.grounding.points.filter((p) => p.label).map((p) => `${p.x} ${p.y}`)));
  const mask = made && made.masks[(made.looking ? null : made.preview) ?? made.chosen];
  return [
    mask ? h("path", { class: "ph-new", d: mask.path }) : null,
    others.map((one) => one.grounding.points.filter((p) => p.label).map((p) => dot(p, unit * 0.6))),
    shown ? [
      shown.box ? h("rect", { class: "ph-box", x: shown.box[0], y: shown.box[1], width: shown.box[2] - shown.box[0], height: shown.box[3] - shown.box[1] }) : null,
      made ? shown.strokes.map(stroke) : null,
      shown.points.filter((p) => p.label || !taken.has(`${p.x} ${p.y}`)).map((p) => dot(p, unit)),
    ] : null,
  ];
}

function dot(click, unit) {
  const r = 5 * unit, s = 2.6 * unit;
  return h("g", {},
    h("circle", { class: `ph-dot ${click.label ? "in" : "out"}`, cx: click.x, cy: click.y, r }),
    h("line", { class: "ph-sign", x1: click.x - s, x2: click.x + s, y1: click.y, y2: click.y }),
    click.label ? h("line", { class: "ph-sign", x1: click.x, x2: click.x, y1: click.y - s, y2: click.y + s }) : null);
}

function stroke(one) {
  if (one.tool === "scissors") return h("polygon", { class: `ph-cut ${one.effect}`, points: list(one.points) });
  const points = one.points.length > 1 ? one.points : [one.points[0], [one.points[0][0] + 0.01, one.points[0][1]]];
  return h("polyline", { class: `ph-stroke ${one.effect}`, points: list(points), "stroke-width": 2 * one.radius });
}

export function live(data, state, unit) {
  const { drag, cut, ramp, pointer } = state;
  const out = [];
  if (drag?.kind === "box") {
    const [a, b] = [drag.from, drag.to];
    out.push(h("rect", { class: "ph-box", x: Math.min(a[0], b[0]), y: Math.min(a[1], b[1]), width: Math.abs(a[0] - b[0]), height: Math.abs(a[1] - b[1]) }));
  }
  if (drag?.kind === "stroke") out.push(stroke({ tool: "brush", effect: drag.effect, radius: state.radius, points: drag.points }));
  if (state.tool === "brush" && pointer) out.push(h("circle", { class: `ph-ring ${state.effect === "erase" ? "erase" : ""}`, cx: pointer[0], cy: pointer[1], r: state.radius }));
  if (cut) {
    const points = [...cut.ways.flat(), ...(cut.live || [])];
    out.push(h("polyline", { class: `ph-cut ${state.effect}`, points: list(points.length ? points : cut.anchors) }));
    out.push(cut.anchors.map(([x, y]) => h("circle", { class: "ph-dot in", cx: x, cy: y, r: 3.5 * unit })));
  }
  if (ramp?.length) {
    const points = ramp.length < 3 && pointer ? [...ramp, pointer] : ramp;
    out.push(h("polygon", { class: "ph-ramp", points: list(points) }));
    out.push(ramp.map(([x, y]) => h("circle", { class: "ph-dot in", cx: x, cy: y, r: 4.5 * unit })));
  }
  if (state.tool === "horizon") out.push(horizon(data, state, unit));
  if (state.tool === "measure") out.push(ruler(state, pointer, unit));
  if (state.tool === "way") out.push(data.objects.map((one) => ways(one, drag, unit)));
  if (state.tool === "ground") out.push(data.objects.map((one) => groundLine(one, data, drag, unit)));
  return out;
}

// The ground straight below a thing in the air, and how far up it is.
function groundLine(one, data, drag, unit) {
  const mine = drag?.kind === "ground" && drag.name === one.name;
  const ground = mine ? [one.ways.at[0], drag.to[1]] : one.ways?.ground;
  if (!ground) return null;
  // A grip is always inside the photo, also where the ground it stands for is not.
  const x = ground[0], y = within(ground[1], data.size[1], unit), half = 0.06 * data.size[0];
  return h("g", { class: "ph-ground", "data-ground": one.name },
    h("line", { class: "ph-horizon", "stroke-dasharray": "4 4", x1: x, x2: x, y1: one.ways.at[1], y2: y }),
    h("line", { class: "ph-horizon", x1: x - half, x2: x + half, y1: y, y2: y }),
    h("circle", { class: "ph-horizon-grip", cx: x, cy: y, r: 6 * unit }));
}

// Where a thing goes, and, dashed, where its own front points.
function ways(one, drag, unit) {
  if (!one.ways) return null;
  const { at, goes, front } = one.ways;
  const mine = drag?.kind === "way" && drag.name === one.name;
  return [front && !mine ? arrow(at, front, "ph-way front", unit) : null, mine ? arrow(drag.from, drag.to, "ph-way", unit) : goes ? arrow(at, goes, "ph-way", unit) : null];
}

function arrow([x0, y0], [x1, y1], kind, unit) {
  const far = Math.hypot(x1 - x0, y1 - y0);
  if (far < 2 * unit) return null;
  const [ux, uy] = [(x1 - x0) / far, (y1 - y0) / far], size = 10 * unit;
  const head = [[x1, y1], [x1 - ux * size - uy * size * 0.55, y1 - uy * size + ux * size * 0.55], [x1 - ux * size + uy * size * 0.55, y1 - uy * size - ux * size * 0.55]];
  return h("g", { class: kind }, h("line", { class: "under", x1: x0, y1: y0, x2: x1, y2: y1 }), h("line", { x1: x0, y1: y0, x2: x1, y2: y1 }), h("polygon", { points: list(head) }));
}

function ruler({ rule, measured }, pointer, unit) {
  const points = rule.length === 1 && pointer ? [...rule, pointer] : rule;
  if (!points.length) return null;
  const far = (metres) => (metres < 1 ? `${(metres * 100).toFixed(1)} cm` : `${metres.toFixed(2)} m`);
  const [x, y] = points.at(-1);
  return h("g", { class: "ph-rule" }, points.length > 1 ? h("polyline", { points: list(points) }) : null,
    points.map(([a, b]) => h("circle", { class: "ph-dot in", cx: a, cy: b, r: 4 * unit })),
    rule.length === 2 && measured ? h("text", { class: "ph-name", x: x + 8 * unit, y: y - 8 * unit, style: `font-size:${13 * unit}px;stroke-width:${3 * unit}px` }, far(measured.metres), Math.abs(measured.up) > 0.005 ? ` (${far(Math.abs(measured.up))} ${measured.up > 0 ? "up" : "down"})` : "") : null);
}

const GRIP = 7; // pixels of the screen that a grip keeps from the photo's edge
const ENDS = 0.4; // where the grips at the ends are, as a share of the width beside the middle
export const within = (y, height, unit) => Math.max(GRIP * unit, Math.min(height - GRIP * unit, y));

function horizon(data, state, unit) {
  const row = state.row ?? data.horizon;
  if (row === null || row === undefined) return null;
  const [width, height] = data.size;
  const at = within(row, height, unit);
  const away = row < 0 ? `${Math.round(-row)} px above` : row > height ? `${Math.round(row - height)} px below` : `row ${Math.round(row)}`;
  const roll = state.roll ?? data.roll ?? 0;
  const tilted = Math.abs(roll) < 0.05 ? "" : `, tilted by ${Math.abs(roll).toFixed(1)}°`;
  const text = 12 * unit, slope = Math.abs(rise(roll, width / 2));
  // A grip is always inside the photo, also where its place on the line is not.
  const grip = (x, r) => h("circle", { class: "ph-horizon-grip", cx: width / 2 + x, cy: within(at - rise(roll, x), height, unit), r: r * unit });
  return h("g", {},
    h("line", { class: "ph-horizon", x1: 0, x2: width, y1: at + rise(roll, width / 2), y2: at - rise(roll, width / 2), "stroke-dasharray": at === row ? null : "6 4" }),
    grip(0, 6), grip(-ENDS * width, 4), grip(ENDS * width, 4),
    h("text", { class: "ph-name", x: 8 * unit, y: Math.max(16 * unit, Math.min(height - 8 * unit, at > height / 2 ? at - slope - 10 * unit : at + slope + 20 * unit)), style: `font-size:${text}px;stroke-width:${2.5 * unit}px` }, `Horizon: ${away}${tilted}`));
}

// A mask on its piece of the photo.
export function thumbnail(data, mask) {
  const numbers = mask.path.match(/-?[\d.]+/g)?.map(Number) || [0, 0, data.size[0], data.size[1]];
  const xs = numbers.filter((_, i) => i % 2 === 0), ys = numbers.filter((_, i) => i % 2 === 1);
  const low = [Math.min(...xs), Math.min(...ys)], high = [Math.max(...xs), Math.max(...ys)];
  const side = Math.max(high[0] - low[0], high[1] - low[1], 8) * 1.25;
  const [x, y] = [(low[0] + high[0] - side) / 2, (low[1] + high[1] - side) / 2];
  return h("svg", { viewBox: `${x} ${y} ${side} ${side}`, "aria-hidden": "true" },
    h("image", { href: data.image, x: 0, y: 0, width: data.size[0], height: data.size[1] }),
    h("path", { d: `M${x} ${y}h${side}v${side}h${-side}Z${mask.path}`, "fill-rule": "evenodd", fill: "#0c0e12", "fill-opacity": ".72" }),
    h("path", { d: mask.path, fill: "none", stroke: "#ffd84d", "stroke-width": 2, style: "vector-effect:non-scaling-stroke" }));
}
