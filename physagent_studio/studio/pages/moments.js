// Moments: a link to this session at this round and frame, a new round that plays by itself once,
// and the eye led to what it changed.

import { h } from "./dom.js";
import { on, scrub, send, value } from "./wire.js";

export function copyLink() {
  const run = value("run"), head = value("playhead"), rounds = value("rounds");
  if (!run?.session) return;
  const parts = { session: run.session, round: rounds?.shown?.id || "", frame: String(head?.frame ?? 0) };
  const address = `${location.origin}/#${new URLSearchParams(parts)}`;
  const told = () => dispatchEvent(new CustomEvent("told", { detail: "The link is copied: it opens this session at this round and frame." }));
  navigator.clipboard?.writeText(address).then(told, () => byHand(address)) ?? byHand(address);
}

// Where the clipboard is closed to the page, the link is there to be taken by hand.
function byHand(address) {
  const field = h("input", { type: "text", value: address, "aria-label": "Link to this moment", readonly: true });
  const shade = h("div", { class: "shade", onpointerdown: (e) => { if (e.target === shade) shade.remove(); }, onkeydown: (e) => { if (e.key === "Escape") { e.stopPropagation(); shade.remove(); } } }, h("div", { class: "dialog narrow", role: "dialog", "aria-label": "Link" }, h("div", { class: "body" }, field)));
  document.body.append(shade);
  field.focus();
  field.select();
}

// What the address asks for is gone to step by step, each once the one before is there. It stays in
// the address until then, so that a page that is loaded anew on the way there arrives all the same.
export function startLinks() {
  let wanted = null;
  const read = () => {
    const parts = new URLSearchParams(location.hash.slice(1));
    if (!parts.get("session")) return;
    wanted = { session: parts.get("session"), round: parts.get("round"), frame: Number(parts.get("frame") || 0), asked: false };
    go();
  };
  function go() {
    const run = value("run"), rounds = value("rounds");
    if (!wanted || !run || !rounds || !value("playhead")) return;
    if (run.session !== wanted.session) {
      // Whoever opens another session meanwhile has gone elsewhere.
      if (wanted.asked && run.session !== wanted.from) return leave();
      if (!wanted.asked) { wanted.asked = true; wanted.from = run.session; send({ do: "open", key: `session:${wanted.session}` }); }
      return;
    }
    if (run.busy) return;
    const row = rounds.rounds.find((one) => one.id === wanted.round);
    if (row && !row.shown) return void (wanted.sent || send({ do: "round", id: row.head ? null : row.id }), wanted.sent = true);
    if (!wanted.scrubbed && value("playhead").frame !== wanted.frame) return void (wanted.scrubbed = true, scrub(wanted.frame));
    leave();
  }
  function leave() {
    wanted = null;
    history.replaceState(null, "", location.pathname);
  }
  for (const channel of ["run", "rounds", "playhead"]) on(channel, go);
  addEventListener("hashchange", read);
  read();
}

export function startAutoplay(wanted) {
  let known = null; // the session, its rounds with a run, and whether the newest was played
  on("rounds", (data) => {
    const session = value("run")?.session;
    // By number: of a long history only a part is listed.
    const ran = Math.max(known?.session === session ? known.ran : 0, ...data.rounds.map((one) => (one.stage === "simulation" ? one.number : 0)));
    const fresh = known && known.session === session && ran > known.ran && data.shown?.stage === "simulation";
    known = { session, ran };
    if (!fresh || data.readOnly) return;
    if (wanted()) send({ do: "play", on: true, once: true });
    setTimeout(() => show(data.shown.changes || []), 300);
  });
}

// The bars that the round changed light up for a moment.
function show(changes) {
  for (const one of changes) {
    const action = /^event\.actions\.([^.]+)/.exec(one.path)?.[1] || one.added;
    const bar = action && document.querySelector(`.tl [data-action="${CSS.escape(action)}"]`);
    if (!bar) continue;
    bar.classList.add("changed");
    setTimeout(() => bar.classList.remove("changed"), 4000);
  }
  document.querySelector(".changes")?.classList.add("lit");
}
