// Result: gentler or harder, slower or faster, how sturdy, and how the camera may have been held.

import { button, h } from "./dom.js";
import { attempt, dropAttempt, endAttempt, on, retime, send, value } from "./wire.js";

const WIDEST = 3; // how many times stronger, or weaker, one drag may make the event
const SLOWEST = 0.25, FASTEST = 4;

export function makeSliders(show) {
  let effort = 0; // −1 to 1 while it is dragged
  let pace = null; // the time factor while it is dragged

  const ratio = (at) => WIDEST ** at;
  const neat = (number) => String(Number(number.toPrecision(2)));

  function push(at) {
    effort = at;
    attempt({ do: "scale", effort: ratio(at), keep: false });
    show();
  }
  function pushed(event) {
    const kept = ratio(effort);
    effort = 0;
    event.target.value = "0"; // what has the focus is not drawn over
    dropAttempt();
    if (Math.abs(kept - 1) > 0.01) send({ do: "scale", effort: Number(kept.toPrecision(3)), keep: true });
    else endAttempt();
    show();
  }
  function turn(at) {
    pace = factorOf(at);
    attempt({ do: "scale", pace, keep: false });
    show();
  }
  function turned() {
    const kept = pace;
    pace = null;
    dropAttempt();
    if (kept !== null) retime(kept, show);
    show();
  }
  // Usual factors are easy to hit: a half, a third, a quarter, real time.
  const factorOf = (at) => {
    const free = 2 ** at;
    return [0.25, 1 / 3, 0.5, 1, 2, 4].find((one) => Math.abs(Math.log2(one / free)) < 0.08) ?? Number(Math.min(FASTEST, Math.max(SLOWEST, free)).toPrecision(3));
  };

  const slide = (label, left, right, props, said) => h("label", { class: "slide" },
    h("span", { class: "row" }, h("span", { class: "muted" }, left), h("span", { class: "num now" }, said), h("span", { class: "muted" }, right)),
    h("input", { type: "range", "aria-label": label, ...props }));

  function draw(readOnly) {
    const line = value("timeline");
    if (!line || readOnly || !line.lanes.some((lane) => lane.actions.length)) return null;
    const tried = value("attempt"), held = tried && (effort || pace !== null) ? (tried.problem ? "not possible" : tried.of ? `${tried.holds} of ${tried.of} hold` : "") : "";
    const factor = pace ?? line.pace.factor;
    return h("div", { class: "sliders", role: "group", "aria-label": "How it happens", key: "sliders" },
      slide("Gentler or harder: all efforts together", "gentler", "harder", { min: -1, max: 1, step: 0.02, value: String(effort), title: "Every push, spin and wind of the event together; letting go keeps it", oninput: (e) => push(Number(e.target.value)), onchange: pushed }, effort ? `× ${neat(ratio(effort))}${held ? ` · ${held}` : ""}` : "as it is"),
      slide("Slower or faster", "slower", "faster", { min: -2, max: 2, step: 0.02, value: String(Math.log2(factor)), title: "How fast the clip is shown; what you choose is pinned", oninput: (e) => turn(Number(e.target.value)), onchange: turned }, `${Math.abs(factor - 1) < 0.005 ? "real time" : `${neat(factor)} × real time`}${pace !== null && held ? ` · ${held}` : ""}${pace === null && line.pace.pinned ? " · pinned" : ""}`));
  }

  on("attempt", () => { if (effort || pace !== null) show(); });
  return draw;
}

// In how many runs it holds where its numbers are a little other, and what breaks it first.
export function sturdiness(found, busy) {
  if (!found) return null;
  const known = found.holds !== null, share = (100 * (found.holds || 0)) / found.runs;
  const go = () => send({ do: "probe", what: "sturdiness" });
  return h("div", { class: "sliders", role: "group", "aria-label": "How sturdy it is", key: "sturdiness" },
    !known ? h("div", { class: "row" }, h("span", { class: "grow muted" }, "How sturdy is it?"), button(`Run it ${found.runs} times`, go, { class: "b small", disabled: busy, title: "Each time with weight, friction, places and pushes moved a little, within what nobody knows for certain" }))
      : [h("div", { class: "row" }, h("b", { class: "num grow" }, `Holds in ${found.holds} of ${found.runs} runs`), h("span", { class: "bar tally", "aria-hidden": "true" }, h("i", { style: `width:${share}%` }))),
        found.reason ? h("p", { class: "muted" }, "First to break: ", found.reason, ".") : h("p", { class: "muted" }, "Weight, friction, places and pushes may all be a little different."),
        h("p", { class: "faint" }, found.reason ? "All runs are drawn in the scene; those that fail in orange." : "All runs are drawn in the scene.")]);
}

// What each change of an accepted proposal is to thank for.
export function credit(found, busy) {
  if (!found) return null;
  if (!found.known) return h("button", { class: "link", type: "button", disabled: busy, title: "Runs it again with only some of them, in every order", onclick: () => send({ do: "probe", what: "credit" }) }, "Which of these changes brought it about?");
  const told = !found.after ? "Run again, it does not hold with all of them." : found.before ? "It happens without any of them as well." : found.exact ? "" : "Shares are taken from a sample of orders.";
  return h("div", { class: "credit stack", role: "list", "aria-label": "What brought it about", key: "credit" },
    h("p", { class: "muted" }, "What each change is to thank for"),
    found.rows.map((one) => h("div", { class: "hunk", role: "listitem" },
      h("div", { class: "row" }, h("span", { class: "grow" }, one.summary), one.needed ? h("span", { class: "chip ok", title: "Without it the event does not happen" }, "needed") : null, one.percent === null ? null : h("b", { class: "num" }, `${String(one.percent).replace("-", "−")} %`)),
      one.percent === null ? null : h("div", { class: "bar" }, h("i", { style: `width:${Math.max(0, Math.min(100, one.percent))}%` })))),
    told ? h("p", { class: "faint" }, told) : null);
}

// Where a horizon lies in a photo that was taken so: a share of its height from the top.
const HELD = [["from above", -0.6], ["eye level", 0.32], ["low", 0.56]];

// Three pictures of the photo, each with the ground that such a camera would see.
export function cameras(photo, pick) {
  const [width, height] = photo.size;
  const now = HELD.reduce((best, one) => (Math.abs(one[1] * height - photo.horizon) < Math.abs(best[1] * height - photo.horizon) ? one : best));
  return h("div", { class: "cameras", role: "group", "aria-label": "How the camera was held" }, HELD.map(([text, share]) =>
    h("button", { type: "button", key: text, "aria-pressed": String(text === now[0]), title: `The photo was taken ${text === "from above" ? "looking down" : text === "low" ? "from near the ground" : "at eye level"}`, onclick: () => pick(share * height) },
      h("svg", { viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" }, h("image", { href: photo.url, width, height }), grid(share * height, width, height)),
      h("span", {}, text))));
}

// Level ground under a horizon: lines that meet on it, and lines across that crowd towards it.
function grid(row, width, height) {
  const rows = [0.12, 0.22, 0.38, 0.62, 1].map((share) => row + (height - row) * share).filter((y) => y > 0);
  const fan = Array.from({ length: 9 }, (_, i) => (i - 4) * width * 0.4);
  return h("g", { class: "ground" },
    rows.map((y) => h("line", { x1: 0, x2: width, y1: y, y2: y })),
    fan.map((by) => h("line", { x1: width / 2, y1: row, x2: width / 2 + by, y2: height })),
    row > 0 ? h("line", { class: "sky", x1: 0, x2: width, y1: row, y2: row }) : null);
}
