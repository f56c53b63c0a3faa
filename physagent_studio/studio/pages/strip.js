// Strip: the sampled frames of a round, as the verifier sees them; a click goes there.

import { h } from "./dom.js";
import { moment } from "./time.js";
import { on, scrub } from "./wire.js";

export function makeStrip(host) {
  let frames = [];
  let at = -1;

  // The sampled frame that is on view, or the last one before it.
  const nearest = (frame) => frames.reduce((best, one) => (one <= frame ? one : best), frames[0]);

  function mark(frame) {
    const next = nearest(frame);
    if (next === at) return;
    at = next;
    const box = host.querySelector(".evidence");
    if (!box) return;
    for (const one of box.querySelectorAll("button")) {
      const here = Number(one.dataset.frame) === at;
      one.setAttribute("aria-current", String(here));
      one.tabIndex = here ? 0 : -1;
      if (here) box.scrollTo({ left: one.offsetLeft - box.clientWidth / 2 + one.offsetWidth / 2 });
    }
  }

  function step(event) {
    const by = { ArrowLeft: -1, ArrowRight: 1, Home: -frames.length, End: frames.length }[event.key];
    if (!by) return;
    event.preventDefault();
    event.stopPropagation();
    const index = Math.max(0, Math.min(frames.length - 1, frames.indexOf(Number(event.target.closest("button").dataset.frame)) + by));
    scrub(frames[index]);
    host.querySelector(`.evidence [data-frame="${frames[index]}"]`)?.focus();
  }

  // A frame that took too long to render is asked for again; by then it is made.
  function again(event) {
    const image = event.target, tries = Number(image.dataset.tries || 0) + 1;
    image.classList.add("late");
    if (tries > 8) return;
    image.dataset.tries = String(tries);
    const plain = image.getAttribute("src").split("?")[0];
    setTimeout(() => image.setAttribute("src", `${plain}?${tries}`), 800 * tries);
  }

  function show(round) {
    if (!round.strip) return null;
    frames = round.strip.frames;
    const [width, height] = round.strip.size;
    const one = (frame) => h("button", { type: "button", key: `${round.strip.at}${frame}`, "data-frame": frame, title: `${moment(frame)}, frame ${frame}`, "aria-label": `Frame ${frame}`, "aria-current": String(frame === at), tabindex: frame === at || (at < 0 && frame === 0) ? "0" : "-1", onclick: () => scrub(frame) },
      h("img", { loading: "lazy", decoding: "async", draggable: "false", alt: "", onerror: again, onload: (e) => e.target.classList.remove("late"), width: 104, height: Math.round((104 * height) / width), src: `${round.strip.at}${frame}.jpg` }),
      h("span", { class: "num", "aria-hidden": "true" }, moment(frame).replace("at ", "")));
    return h("div", { class: "evidence", role: "group", "aria-label": "Sampled frames", key: "evidence", onkeydown: step }, frames.map(one));
  }

  on("playhead", (head) => { if (frames.length) mark(head.frame); });
  return { show };
}
