// Run: which session, what is happening, what comes next.

import { button, draw, h, iconButton } from "./dom.js";
import { on, send } from "./wire.js";

const POLICIES = [["ask", "I decide"], ["ask_when", "Ask me when unsure"], ["auto", "Decide by itself"]];

export function startRun(host, dialogs) {
  on("run", (run) => {
    const waiting = run.phase === "decide" && !run.draft;
    const over = run.phase === "done" && !run.draft;
    draw(host,
      h("div", { class: "row run-head" },
        h("div", { class: "title grow clip", title: run.title }, run.title || "PhysAgent Studio"),
        iconButton("undo", "Undo (Ctrl+Z)", () => send({ do: "undo" }), { disabled: !run.canUndo }),
        iconButton("redo", "Redo (Ctrl+Shift+Z)", () => send({ do: "undo", forward: true }), { disabled: !run.canRedo }),
        h("button", { class: "b small", type: "button", onclick: dialogs.open }, "Open…")),
      run.prompt ? h("p", { class: "prompt" }, h("q", {}, run.prompt)) : h("p", { class: "prompt" }, run.session ? "No sentence yet." : "Open a case, a photo or an empty scene to begin."),
      run.busy ? busy(run) : null,
      run.busy || !run.session ? null : h("div", { class: "stack" },
        state(run),
        h("div", { class: "row" },
          button(run.draft ? "Run my edits" : over ? "Go on" : run.started ? "Next step" : "Start", () => send({ do: "step" }),
            { class: waiting || over ? "b wide" : "b main wide", disabled: waiting || run.readOnly, title: "Goes on until a decision is needed (R)" }),
          button("Run to the end", () => send({ do: "step", all: true }), { class: "b wide", disabled: run.readOnly || (over && run.realised), title: "Decides by itself, round after round" }))),
      run.session ? h("div", { class: "row wrap", style: "margin-top:10px" },
        h("label", { class: "row grow" }, h("span", { class: "muted hide-narrow" }, "Decisions"),
          h("select", { value: run.policy, "aria-label": "Who decides", onchange: (e) => send({ do: "policy", name: e.target.value }) },
            POLICIES.map(([key, text]) => h("option", { value: key }, text)))),
        h("label", { class: "row" }, h("span", { class: "muted" }, "Rounds"),
          h("span", { class: "num", title: `${run.simulations} simulations so far` }, `${run.used} of`),
          h("input", { type: "number", min: 1, max: 100, value: run.budget, "aria-label": "Most rounds", style: "width:54px",
            onchange: (e) => send({ do: "budget", rounds: Number(e.target.value) }) }))) : null);
    document.title = run.title ? `${run.title} · PhysAgent Studio` : "PhysAgent Studio";
  });
}

function busy(run) {
  const known = run.progress !== null && run.progress !== undefined;
  return h("div", { class: "stack" },
    h("div", { class: "row" },
      h("div", { class: "grow clip", role: "status" }, sentence(run.busy), known ? h("span", { class: "muted num" }, `  ${Math.round(run.progress * 100)} %`) : null),
      button("Cancel", () => send({ do: "cancel" }), { class: "b small" })),
    h("div", { class: known ? "bar" : "bar unknown" }, h("i", { style: known ? `width:${run.progress * 100}%` : "" })));
}

const sentence = (text) => text.charAt(0).toUpperCase() + text.slice(1) + "…";

function state(run) {
  if (run.readOnly) return h("div", { class: "strip warn" }, "An earlier round is open, read-only.");
  if (run.draft) return h("div", { class: "row strip warn" }, h("span", { class: "grow" }, "You have edits that no round has run yet."), h("button", { class: "link", type: "button", onclick: () => send({ do: "discard" }) }, "Discard"));
  if (run.phase === "done") return h("div", { class: run.realised ? "strip ok" : "strip warn" }, run.outcome);
  return h("div", { class: "muted" }, sentence(run.doing).replace("…", "."));
}
