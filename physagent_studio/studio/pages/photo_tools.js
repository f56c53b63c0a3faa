// The photo's tools: what a hand does with the pointer becomes a grounding, a line or a ramp.

import { rise, within } from "./photo_draw.js";
import { makeScissors } from "./photo_scissors.js";
import { attempt, dropAttempt, endAttempt, selected, send } from "./wire.js";

export const TOOLS = [
  ["look", "Look", "Click an outline to select; drag to move, wheel to zoom."],
  ["mask", "Mask", "Click inside; right-click or Alt-click outside; drag a box."],
  ["brush", "Brush", "Paint what belongs to it; right button or Alt erases."],
  ["scissors", "Scissors", "Click along the edge; double-click or Enter closes. Shift: straight."],
  ["horizon", "Horizon", "Drag the line to where level ground would end; drag an end to tilt it."],
  ["way", "This way", "Drag from a thing to where it should go; a dashed arrow is where its front points."],
  ["ground", "Ground line", "Drag the line below a thing in the air to the ground that is straight under it."],
  ["measure", "Measure", "Click two points: how far they are apart in the scene. Escape forgets them."],
  ["ramp", "Ramp", "Click the ramp's toe, then the ground below its upper end, then that end."],
];
const EMPTY = { points: [], box: null, candidate: 0, marks: [], strokes: [], settled: false };

let tickets = 0;

export function makeTools({ stage, data, changed }) {
  const state = { tool: "look", radius: 10, effect: "add", pending: null, cut: null, ramp: null, rule: [], row: null, roll: null, pointer: null, drag: null };

  const named = (name) => data()?.objects.find((one) => one.name === name) || data()?.supports.find((one) => one.name === name);
  const target = () => (state.fresh ? state.fresh : ["object", "support"].includes(selected().kind) ? selected().name : data()?.objects.length === 1 ? data().objects[0].name : "");

  function pick(tool) {
    state.tool = tool;
    [state.cut, state.ramp, state.drag, state.row, state.roll, state.rule] = [null, tool === "ramp" ? [] : null, null, null, null, []];
    stage.stage.dataset.tool = tool;
    changed();
  }

  // --- the grounding that is being made ------------------------------------------------------

  // Marks that nothing was chosen for have no name, until it is said which thing they belong to.
  function pending() {
    const name = target();
    if (!state.pending || state.pending.name !== name) {
      const known = named(name)?.grounding || EMPTY;
      state.pending = { name, grounding: structuredClone(known), past: [], changes: [], masks: [], chosen: known.candidate, ticket: 0, problem: "" };
    }
    return state.pending;
  }

  function alter(change) {
    const one = pending();
    if (one.sent) return;
    mark(one, change);
    one.name ? ask(one) : changed();
  }

  function mark(one, change) {
    one.past.push(structuredClone(one.grounding));
    one.changes.push(change);
    change(one.grounding);
  }

  // Another thing was chosen: what was being made of the last one is dropped; marks that had no
  // name yet are its marks.
  function turned() {
    if (state.fresh || state.pending?.sent || (state.pending && state.pending.name === target())) return;
    const kept = state.pending?.name === "" ? state.pending.changes : [], cut = state.cut?.name === "" ? state.cut : null;
    drop();
    state.cut = cut;
    adopt(kept);
  }

  function adopt(changes) {
    if (!changes.length) return;
    const one = pending();
    for (const change of changes) mark(one, change);
    ask(one);
  }

  // What is named here is new, or known by that name.
  function begin(name) {
    const kept = state.pending?.name === "" ? state.pending.changes : [];
    drop();
    if (named(name)) send({ do: "select", kind: data().supports.some((one) => one.name === name) ? "support" : "object", name });
    else state.fresh = name;
    pick("mask");
    adopt(kept);
  }

  function ask(one) {
    one.ticket = ++tickets;
    // The masks on view answer the question before: none of them can be taken any more.
    [one.problem, one.more, one.early, one.wanted, one.lost, one.looking, one.soon] = ["", false, false, -1, 0, true, false];
    one.waiting = send({ do: "masks", name: one.name, grounding: one.grounding, ticket: one.ticket });
    changed();
  }

  // The masks of what is marked already, to choose another one from.
  function look() {
    const known = named(target())?.grounding;
    if (!known || !(known.points?.length || known.box || known.strokes?.length)) return;
    ask(pending());
  }

  function found(answer) {
    const one = state.pending;
    if (!one || answer.ticket !== one.ticket) return;
    one.looking = false;
    one.more = Boolean(answer.more);
    one.early = Boolean(answer.early);
    one.waiting = one.more || one.early;
    one.problem = answer.problem || "";
    one.masks = answer.masks || [];
    one.chosen = Math.min(one.chosen, Math.max(0, one.masks.length - 1));
    if (!one.early && one.wanted >= 0) return settled(one, answer.now || []);
    if (one.soon && one.masks.length) return take(one.chosen);
    changed();
  }

  // A mask that was chosen before the closer look had ended, if it is still there.
  function settled(one, now) {
    const [wanted, at] = [one.wanted, now[one.wanted] ?? -1];
    one.wanted = -1;
    if (at >= 0) return take(at);
    [one.lost, one.chosen] = [wanted + 1, 0];
    changed();
  }

  function take(index) {
    const one = state.pending;
    if (!one || one.sent || one.looking || index >= one.masks.length) return;
    one.chosen = index;
    [one.lost, one.soon] = [0, false];
    if (one.early) {
      one.wanted = index;
      return changed();
    }
    const { candidate = index, layer = false } = one.masks[index] || {};
    one.sent = send({ do: "mask", name: one.name, grounding: { ...one.grounding, candidate }, layer });
    changed();
  }

  // The mask that leads; where it is still looked for, once it is found.
  function takeBest() {
    const one = state.pending;
    if (!one?.looking) return take(one?.chosen ?? 0);
    one.soon = true;
    changed();
  }

  function back() {
    const one = state.pending;
    if (state.cut) {
      state.cut.anchors.pop();
      state.cut.ways.pop();
      if (!state.cut.anchors.length) state.cut = null;
      return changed();
    }
    if (state.ramp?.length) {
      state.ramp.pop();
      return changed();
    }
    if (!one || one.past.length < 2) return drop();
    one.grounding = one.past.pop();
    one.changes.pop();
    one.name ? ask(one) : changed();
  }

  function drop() {
    [state.pending, state.cut, state.drag, state.fresh, state.rule] = [null, null, null, "", []];
    if (state.ramp) state.ramp = [];
    changed();
  }

  const busy = () => Boolean(state.cut || state.ramp?.length || state.rule.length || (state.pending && !state.pending.sent));

  // What has arrived from the server makes what was sent the truth.
  function settle() {
    if (state.pending?.sent) [state.pending, state.fresh] = [null, ""];
    if (!state.drag) [state.row, state.roll] = [null, null];
  }

  function refused() {
    if (state.pending) state.pending.sent = false;
    if (state.cut) state.cut.fixing = "";
    [state.row, state.roll] = [null, null];
    changed();
  }

  // What was asked over a line that was lost is never answered.
  function resume() {
    if (state.cut) state.cut.fixing = "";
    if (state.pending?.waiting || state.pending?.looking) ask(state.pending);
  }

  const { way, edge, anchor, close } = makeScissors({ state, stage, changed, target, ticket: () => ++tickets, alter, refused });

  // A hand that points at a thing which was only found by its words says where it is: anew. What
  // the hand said to lie outside stays so.
  function anew(grounding) {
    if (grounding.proposed) [grounding.points, grounding.candidate, grounding.proposed] = [grounding.points.filter((p) => !p.label), 0, false];
    return grounding;
  }

  // --- the pointer ---------------------------------------------------------------------------

  function brush(phase, point, event) {
    const erase = event.button === 2 || event.altKey || state.effect === "erase";
    if (phase === "down") state.drag = { kind: "stroke", effect: erase ? "erase" : "add", points: [point] };
    else if (phase === "move" && state.drag) {
      const last = state.drag.points.at(-1);
      if (Math.hypot(last[0] - point[0], last[1] - point[1]) > Math.max(0.8, state.radius * 0.25) && state.drag.points.length < 590) state.drag.points.push(point);
    } else if (phase === "up" && state.drag) {
      const { points, effect } = state.drag;
      state.drag = null;
      alter((g) => g.strokes.push({ tool: "brush", effect, radius: state.radius, points: points.map(([x, y]) => [round(x), round(y)]) }));
    }
  }

  function mask(phase, point, event) {
    if (phase === "down") {
      const under = target() ? null : event.target.closest?.("[data-kind=object]");
      state.drag = { kind: "box", from: point, to: point, out: event.button === 2 || event.altKey, under };
    } else if (phase === "move" && state.drag) state.drag.to = point;
    else if (phase === "up" && state.drag) {
      const { from, to, out, under } = state.drag;
      state.drag = null;
      if (under) send({ do: "select", kind: "object", name: under.dataset.name });
      const far = Math.max(Math.abs(from[0] - to[0]), Math.abs(from[1] - to[1]));
      if (!out && far > 6 * stage.unit() && far > 3) alter((g) => { anew(g).box = [Math.min(from[0], to[0]), Math.min(from[1], to[1]), Math.max(from[0], to[0]), Math.max(from[1], to[1])].map(round); });
      else alter((g) => (out ? g : anew(g)).points.push({ x: round(from[0]), y: round(from[1]), label: out ? 0 : 1 }));
      // Other marks have other masks: the best of them leads, whichever was taken of the last.
      if (state.pending && !state.pending.sent) state.pending.chosen = 0;
    }
  }

  function horizon(phase, point) {
    const [x, y] = [point[0] - data().size[0] / 2, point[1]];
    const row = state.row ?? data().horizon ?? y, roll = state.roll ?? data().roll ?? 0;
    if (phase === "down") {
      // A line beyond the photo is drawn at its edge, and is taken from there.
      const [width, height] = data().size, unit = stage.unit();
      const off = Math.max(0, Math.min(height, row)) - rise(roll, x) - y;
      const grip = within(within(row, height, unit) - rise(roll, x), height, unit);
      const tilts = Math.abs(x) > 0.3 * width && Math.abs(grip - y) < 20 * unit;
      // Far from the line a click takes it along.
      const far = !tilts && Math.abs(off) > 60 * unit;
      state.drag = { kind: "horizon", from: y, off: far ? 0 : off, tilts, up: rise(roll, x), moved: far };
    }
    if (!state.drag) return;
    state.drag.moved ||= Math.abs(y - state.drag.from) > 2 * stage.unit();
    if (state.drag.moved) {
      [state.row, state.roll] = [round(row), roll];
      if (state.drag.tilts) state.roll = tilt(state.drag.up + state.drag.from - y, x);
      else state.row = round(y + state.drag.off + rise(roll, x));
    }
    if (phase !== "up") return;
    if (state.drag.moved) send({ do: "horizon", row: state.row, roll: state.roll });
    state.drag = null;
  }

  function ramp(phase, point) {
    if (phase !== "up" || !state.ramp) return;
    state.ramp.push(point.map(round));
    if (state.ramp.length === 3) {
      const [toe, foot, top] = state.ramp;
      const one = data().supports.find((item) => item.ramp && item.name === selected().name);
      send({ do: "ramp", name: one ? one.name : null, toe, foot, top });
      state.ramp = [];
    }
  }

  // An arrow from a thing to where it should go: tried under the pointer, kept where it is let go.
  function heads(phase, point, event) {
    if (phase === "down") {
      const name = event.target.closest?.("[data-kind=object]")?.dataset.name || nearest(point) || target();
      if (!name) return;
      send({ do: "select", kind: "object", name });
      state.drag = { kind: "way", name, from: centre(name) || point, to: point, moved: false };
    } else if (phase === "move" && state.drag) {
      state.drag.to = point;
      state.drag.moved ||= Math.hypot(point[0] - state.drag.from[0], point[1] - state.drag.from[1]) > 8 * stage.unit();
      if (state.drag.moved) attempt({ do: "aim", name: state.drag.name, end: point.map(round), keep: false });
    } else if (phase === "up" && state.drag) {
      const { name, moved } = state.drag;
      state.drag = null;
      dropAttempt();
      if (moved) send({ do: "aim", name, end: point.map(round), keep: true });
      else endAttempt();
    }
  }

  // The ground below a thing that hangs or floats says how far away it is; it keeps its place here.
  function below(phase, point, event) {
    if (phase === "down") {
      const name = event.target.closest?.("[data-ground]")?.dataset.ground || event.target.closest?.("[data-kind=object]")?.dataset.name || nearestLine(point) || target();
      if (!name || !named(name)?.ways) return;
      send({ do: "select", kind: "object", name });
      state.drag = { kind: "ground", name, to: point, moved: false };
    } else if (phase === "move" && state.drag) {
      [state.drag.to, state.drag.moved] = [point, true];
      attempt({ do: "ground", name: state.drag.name, end: under(), keep: false });
    } else if (phase === "up" && state.drag) {
      const { name, moved } = state.drag, end = under();
      state.drag = null;
      dropAttempt();
      if (moved) send({ do: "ground", name, end, keep: true });
      else endAttempt();
    }
  }

  const under = () => [centre(state.drag.name)[0], state.drag.to[1]].map(round);

  function nearestLine([x, y]) {
    const found = (data()?.objects || []).filter((one) => one.ways?.ground).map((one) => [Math.hypot(one.ways.ground[0] - x, one.ways.ground[1] - y), one.name]).sort((a, b) => a[0] - b[0])[0];
    return found && found[0] < 0.12 * data().size[0] ? found[1] : "";
  }

  // Two points, and how far apart they are; a third begins anew.
  function rule(phase, point) {
    if (phase !== "up") return;
    state.rule = state.rule.length === 2 ? [point.map(round)] : [...state.rule, point.map(round)];
    state.measured = null;
    if (state.rule.length === 2) send({ do: "measure", a: state.rule[0], b: state.rule[1] });
  }

  // A thing with a thin outline is easily missed: the one that is near enough is meant.
  function nearest([x, y]) {
    const away = (one) => Math.hypot(one.ways.at[0] - x, one.ways.at[1] - y);
    const found = (data()?.objects || []).filter((one) => one.ways).sort((a, b) => away(a) - away(b))[0];
    return found && away(found) < 0.12 * data().size[0] ? found.name : "";
  }

  const centre = (name) => named(name)?.ways?.at;

  function on(phase, raw, event) {
    const point = stage.inside(raw);
    state.pointer = phase === "leave" ? null : point;
    if (phase === "cancel") [state.drag] = [null, endAttempt()];
    else if (phase === "pick" || data()?.readOnly) {
      const under = document.elementFromPoint(event.clientX, event.clientY)?.closest?.("[data-name]");
      if (phase === "pick") send(under ? { do: "select", kind: under.dataset.kind, name: under.dataset.name } : { do: "select", kind: "none" });
    } else if (state.tool === "mask") mask(phase, point, event);
    else if (state.tool === "brush") brush(phase, point, event);
    else if (state.tool === "horizon") horizon(phase, raw);
    else if (state.tool === "ramp") ramp(phase, point);
    else if (state.tool === "way") heads(phase, point, event);
    else if (state.tool === "ground") below(phase, point, event);
    else if (state.tool === "measure") rule(phase, point);
    else if (state.tool === "scissors") {
      if (phase === "up" && event.button === 0 && event.detail < 2) anchor(point, event.shiftKey);
      else if (phase === "double") close(event.shiftKey);
      else if (phase === "move" && state.cut && !state.cut.fixing) way(point, event.shiftKey);
    }
    changed();
  }

  function key(event) {
    if (event.key === "Escape") return (busy() ? drop() : state.tool !== "look" ? pick("look") : false);
    // What was chosen is on its way: a second press of its key means nothing else.
    if (state.pending?.sent && !event.ctrlKey && !event.metaKey && !event.altKey && /^([1-4]|Enter)$/.test(event.key)) return true;
    if (!busy()) return false;
    const undo = (event.ctrlKey || event.metaKey) && !event.shiftKey && event.key.toLowerCase() === "z";
    if (undo) return back();
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    if (event.key === "Enter") return state.cut ? close(event.shiftKey) : takeBest();
    if (state.pending && /^[1-4]$/.test(event.key)) return take(Number(event.key) - 1);
    return false;
  }

  return { state, pick, target, take, drop, back, busy, found, edge, settle, refused, resume, on, key, turned, begin, look };
}

const LEVEL = 0.4; // degrees within which a line is level
// The tilt of a line that has risen so far beside the photo's middle.
function tilt(up, x) {
  const roll = (Math.atan(up / x) * 180) / Math.PI;
  return Math.abs(roll) < LEVEL ? 0 : Math.max(-45, Math.min(45, Math.round(roll * 100) / 100));
}

const round = (number) => Math.round(number * 10) / 10;
