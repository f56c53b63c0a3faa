// A person's own turn: the verdict that the loop waits for, or what a repair by hand is made with.

import { button, h } from "./dom.js";
import { send } from "./wire.js";

export function makeByHand() {
  let about = ""; // the round and stage that the words belong to
  let words = "";

  function verdict(shown) {
    const scene = shown.stage === "reconstruction";
    if (about !== `${shown.id}/${shown.stage}`) { about = `${shown.id}/${shown.stage}`; words = ""; }
    const give = (passed) => send({ do: "overrule", passed, words });
    return h("div", { class: "card accent stack", key: `verdict-${about}`, role: "group", "aria-label": "Your verdict", style: "margin-top:14px" },
      h("span", { class: "title" }, scene ? "Does the scene match the photo?" : "Does the event happen?"),
      h("p", { class: "muted" }, "Your word decides; what was measured stands below."),
      h("textarea", { rows: 2, placeholder: scene ? "If not: what is wrong with it?" : "If not: what should be different?", "aria-label": "Your reason", oninput: (e) => (words = e.target.value) }),
      h("div", { class: "row" },
        button(scene ? "It matches" : "It happens", () => give(true), { class: "b main wide", title: "Goes on (A)", "data-act": "accept" }),
        button("It does not", () => give(false), { class: "b bad wide", title: "A repair is looked for (X)", "data-act": "reject" })));
  }

  const repair = () => h("div", { class: "card accent stack", key: "own-repair", role: "group", "aria-label": "Your repair", style: "margin-top:14px" },
    h("span", { class: "title" }, "Your repair"),
    h("p", { class: "muted" }, "Change what went wrong: in the scene, on the timeline, in the inspector or in the program's text. What comes of it is shown at once; “Run my edits” makes it the next round."));

  return (data) => (data.turn === "verifier" ? verdict(data.shown) : data.turn === "planner" ? repair() : null);
}
