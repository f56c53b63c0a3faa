// A dial: a needle that is turned by hand; what it would make is tried while it turns.

import { h } from "./dom.js";
import { attempt, dropAttempt, endAttempt } from "./wire.js";

let turning = ""; // the path of the value whose needle is under the pointer

// angle: of the needle, radians, counter-clockwise from the right. valueAt gives the value of an
// angle, `put` takes it over, `redraw` shows what was there before.
export function dial({ path, label, angle, off, mark, valueAt, put, redraw }) {
  const turn = (event) => {
    const box = event.currentTarget.getBoundingClientRect();
    const to = Math.atan2(box.top + box.height / 2 - event.clientY, event.clientX - box.left - box.width / 2);
    const needle = event.currentTarget.querySelector("line");
    needle.setAttribute("x2", 32 + 24 * Math.cos(to));
    needle.setAttribute("y2", 32 - 24 * Math.sin(to));
    return valueAt(to);
  };
  const mine = () => turning === path;
  const hands = off ? {} : {
    onpointerdown: (e) => { if (e.button === 0) { turning = path; e.currentTarget.setPointerCapture(e.pointerId); } },
    onpointermove: (e) => { if (mine()) attempt([{ op: "set", path, value: turn(e) }]); },
    onpointerup: (e) => { if (mine()) { turning = ""; dropAttempt(); put(turn(e)); } },
    onpointercancel: () => { if (mine()) { turning = ""; endAttempt(); redraw(); } },
  };
  return h("svg", { width: 64, height: 64, viewBox: "0 0 64 64", style: "cursor:grab;touch-action:none;flex:none", role: "img", "aria-label": label, ...hands },
    h("circle", { cx: 32, cy: 32, r: 29, fill: "var(--raised)", stroke: "var(--line-2)" }),
    mark ? h("path", { d: mark, stroke: "var(--faint)" }) : null,
    h("line", { x1: 32, y1: 32, x2: 32 + 24 * Math.cos(angle), y2: 32 - 24 * Math.sin(angle), stroke: "var(--accent)", "stroke-width": 3, "stroke-linecap": "round" }),
    h("circle", { cx: 32, cy: 32, r: 3, fill: "var(--text)" }));
}
