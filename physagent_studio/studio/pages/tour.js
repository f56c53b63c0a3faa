// Tour: five steps through the page for whoever comes first; can be skipped, and taken again.

import { draw, h } from "./dom.js";
import { on, value } from "./wire.js";

const SEEN = "studio.toured";
const STEPS = [
  ["#centre", "The scene", "Your photo in three dimensions, seen by the photo's own camera. Drag to look around it; Photo, or the key 0, brings you back. Click a thing to select it everywhere."],
  ["#run", "Start here", "The sentence says what shall happen. Start runs it once and stops where a decision is needed; Run to the end decides by itself. Open… has examples, your sessions and new photos."],
  ["#left", "Rounds", "Each round is one try. Below it: sampled frames, what the sentence demands with what was measured, and the proposed repair, tried out already. Accept it, change its numbers, or reject it and say why."],
  ["#timeline", "Time", "What acts on which thing, and when. Drag a bar to move it, its edges to make it longer; the scene follows while you drag. Space plays."],
  ["#details", "Everything by hand", "Every number of what is selected, and the whole program as text. Nothing is lost: Ctrl+Z goes back over everything. Press ? for all keys and Ctrl+K for every command."],
];

export function startTour(ready) {
  const host = h("div", { id: "tour" });
  document.body.append(host);
  let at = -1;
  let from = null;

  const close = () => {
    if (at < 0) return;
    at = -1;
    localStorage.setItem(SEEN, "true");
    draw(host);
    from?.focus?.({ preventScroll: true });
    from = null;
  };
  const go = (next) => {
    if (next >= STEPS.length) return close();
    at = Math.max(0, next);
    show();
    host.querySelector("[data-focus]")?.focus();
  };
  const start = () => {
    from = from || document.activeElement;
    go(0);
  };

  // Beside the part that is spoken of, inside the window, and never over what tells of the work.
  function place(box) {
    const wide = Math.min(340, innerWidth - 24), gap = 14, high = 190;
    const beside = Math.max(12, Math.min(box.top + 24, innerHeight - high - 12)), middle = box.left + Math.max(0, (box.width - wide) / 2);
    const run = document.getElementById("run").getBoundingClientRect();
    const covers = ({ left, top }) => left < run.right && left + wide > run.left && top < run.bottom && top + high > run.top;
    const places = [{ left: box.right + gap, top: beside }, { left: box.left - gap - wide, top: beside }, { left: middle, top: box.top - high - gap }, { left: middle, top: box.bottom - high - 24 }];
    return places.find((one) => one.left >= 0 && one.left + wide < innerWidth && one.top >= 0 && one.top + high < innerHeight && !covers(one)) || places.at(-1);
  }

  function pressed(event) {
    if (event.key === "Escape") close();
    else if (event.key === "ArrowRight") go(at + 1);
    else if (event.key === "ArrowLeft") go(at - 1);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  function show() {
    if (at < 0) return;
    const [target, title, text] = STEPS[at];
    const box = document.querySelector(target).getBoundingClientRect();
    const { left, top } = place(box);
    const last = at === STEPS.length - 1;
    draw(host,
      h("div", { class: "tour-ring", style: `left:${box.left + 2}px;top:${box.top + 2}px;width:${box.width - 4}px;height:${box.height - 4}px` }),
      h("div", { class: "card tour-card stack", role: "dialog", "aria-label": `Tour, step ${at + 1} of ${STEPS.length}`, "aria-describedby": "tour-text", style: `left:${left}px;top:${top}px`, onkeydown: pressed },
        h("div", { class: "row" }, h("span", { class: "title grow" }, title), h("span", { class: "faint num" }, `${at + 1} of ${STEPS.length}`)),
        h("p", { id: "tour-text", "aria-live": "polite" }, text),
        h("div", { class: "row" },
          h("button", { class: "b quiet", type: "button", onclick: close, hidden: last }, "Skip"),
          h("span", { class: "grow" }),
          h("button", { class: "b", type: "button", onclick: () => go(at - 1), disabled: at === 0 }, "Back"),
          h("button", { class: "b main", type: "button", "data-focus": true, onclick: () => go(at + 1) }, last ? "Done" : "Next"))));
  }

  addEventListener("resize", show);
  // Escape ends it wherever the focus is, but for a dialog that lies over it.
  addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || at < 0 || document.querySelector(".shade")) return;
    event.stopPropagation();
    event.preventDefault();
    close();
  }, true);
  let offered = false;
  on("playhead", () => {
    if (offered || !value("run")) return;
    offered = true;
    if (!localStorage.getItem(SEEN) && ready()) start();
  });
  return { start, close };
}
