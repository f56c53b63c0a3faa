// Presenter: large type, nothing to edit, rounds stepped through by key. The server refuses edits too.

import { draw, h } from "./dom.js";
import { on, present, presenting, send, value } from "./wire.js";

const WORDS = { ok: "It happens", failed: "It does not happen yet", open: "Not judged yet" };

export function startPresenter(left) {
  const host = h("div", { id: "presenter", role: "status", "aria-live": "polite" });
  document.getElementById("centre").append(host);

  function set(wanted) {
    quiet(wanted);
    present(wanted);
    if (wanted) {
      document.documentElement.dataset.presenter = "on";
      left.show("rounds");
    } else delete document.documentElement.dataset.presenter;
    document.activeElement?.blur?.();
    show();
    dispatchEvent(new Event("resize"));
  }

  // Shades of other rounds are off while presenting.
  let hid = false;
  function quiet(wanted) {
    const on = (value("scene")?.switches || []).some((one) => one.what === "ghosts" && one.on);
    if (wanted ? on : hid) send({ do: "show", what: "ghosts", on: !wanted });
    hid = wanted && on;
  }

  function step(by) {
    const all = value("rounds")?.rounds || [];
    const at = all.findIndex((one) => one.shown);
    const next = all[Math.max(0, Math.min(all.length - 1, at + by))];
    if (next) send({ do: "round", id: next.head ? null : next.id });
  }

  function show() {
    if (!presenting()) return draw(host);
    const run = value("run") || {}, rounds = value("rounds") || { rounds: [] };
    const all = rounds.rounds, at = all.findIndex((one) => one.shown), shown = rounds.shown;
    draw(host,
      h("div", { class: "presenter-label row" }, h("span", { class: "chip accent" }, "Presenting"), h("span", { class: "muted grow" }, "N and P step through rounds, Space plays, Escape ends"), h("button", { class: "b small present", type: "button", onclick: () => set(false) }, "End")),
      h("p", { class: "presenter-sentence" }, run.prompt ? `“${run.prompt}”` : run.title || ""),
      shown ? h("p", { class: `presenter-verdict ${shown.verdict}` }, h("span", { class: `dot ${shown.verdict}`, "aria-hidden": "true" }, { ok: "✓", failed: "✕" }[shown.verdict] || "…"), `Round ${at + 1} of ${all.length}: ${WORDS[shown.verdict]}`) : null);
  }

  on("rounds", show);
  on("run", show);
  return { on: () => set(true), off: () => set(false), toggle: () => set(!presenting()), step };
}
