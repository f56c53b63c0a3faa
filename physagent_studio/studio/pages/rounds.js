// Rounds: the history, the checklist, and the decision on the proposal.

import { makeChecklist } from "./checklist.js";
import { makeByHand } from "./by_hand.js";
import { button, draw, h, icon, say } from "./dom.js";
import { cameras, credit, makeSliders, sturdiness } from "./result.js";
import { moment } from "./time.js";
import { inShort, makeProposal } from "./proposal.js";
import { makeStrip } from "./strip.js";
import { on, scrub, send, value } from "./wire.js";

const SAYS = { reconstruction: ["it does not match", "it matches"], simulation: ["it does not happen", "it happens"] };
const MARK = { ok: "✓", failed: "✕", open: "…" };

export function startRounds(host, dock, { showRounds, showPlots, showPhoto }) {
  let data = null;
  let overruling = ""; // the round whose verdict is being overruled
  let words = "";
  const settled = new Set(); // what was found by words and is right

  const show = () => {
    if (!data) return;
    draw(host, page());
    const p = open();
    draw(dock, p ? proposal.bar(p, data.draft, lead) : null);
    dock.hidden = !p;
  };
  // Edits of one's own are the answer to a question that came without a repair.
  const open = () => (data.proposal && (data.proposal.hunks.length || !data.draft) ? data.proposal : null);
  const lead = () => { showRounds(); host.querySelector("[aria-label=Proposal]")?.scrollIntoView({ block: "start" }); };
  const focus = () => setTimeout(() => (dock.querySelector("[data-focus]") || host.querySelector("[data-focus]"))?.focus(), 0);
  const toggle = () => { overruling = overruling === data.shown.id ? "" : data.shown.id; words = ""; show(); focus(); };
  const sliders = makeSliders(() => show());
  const byHand = makeByHand();
  const checklist = makeChecklist(show, focus);
  const mark = (one) => { send({ do: "select", ...one }); showPhoto(); dispatchEvent(new CustomEvent("photo-tool", { detail: "mask" })); };
  const proposal = makeProposal(show, focus, mark);
  const strip = makeStrip(host);

  function page() {
    const shown = data.shown;
    if (!data.rounds.length) return [h("p", { class: "muted" }, "Rounds appear here: each is one try at making the sentence happen, with what was measured and what to change next."), checklist.draw(data)];
    return [
      h("div", { class: "rounds", role: "list", "aria-label": "History" }, beyond(data.before, "earlier"), data.rounds.map(row), beyond(data.after, "later")),
      data.readOnly ? h("div", { class: "strip warn stack", style: "margin-top:8px" },
        h("div", {}, `Round ${shown.number} is open read-only.`),
        h("div", { class: "row" }, button("Go on from here", () => send({ do: "fork", id: shown.id }), { class: "b small" }),
          button("Back to the current round", () => send({ do: "round", id: null }), { class: "b small" }))) : null,
      data.compare ? comparison(data.compare) : null,
      shown && data.turn && !data.draft ? byHand(data) : null,
      shown ? verdict(shown) : null,
      guessed(),
      doubted(),
      shown && (data.draft || shown.stage === "simulation") ? sliders(data.readOnly) : null,
      shown ? sturdiness(data.sturdiness, busy()) : null,
      shown && !data.draft ? strip.show(shown) : null,
      checklist.draw(data),
      data.notUnderstood.length ? h("div", { class: "strip warn", style: "margin-top:8px" }, "Not understood: ", data.notUnderstood.join("; ")) : null,
      data.untested.length ? h("div", { class: "strip warn", style: "margin-top:8px" }, "Nothing tests: ", data.untested.join("; ")) : null,
      shown ? why(shown) : null,
      open() ? proposal.card(data.proposal, data.pinned) : null,
      data.pinned.length || data.hints.length ? memory() : null,
    ];
  }

  // Very long histories are listed around the round on view.
  function beyond(there, which) {
    if (!there) return null;
    return h("div", { class: "row", role: "listitem" }, h("button", { class: "link", type: "button", title: "Look at the nearest of them", onclick: () => send({ do: "round", id: there.id }) }, say(there.count, `${which} round`)));
  }

  // Things that nobody clicked were found by their words, which may be the wrong ones.
  function guessed() {
    const key = data.guessed.join(" ");
    if (!key || data.readOnly || settled.has(key)) return null;
    const names = data.guessed.map((one) => one.replaceAll("_", " "));
    const many = names.length > 1;
    return h("div", { class: "strip warn stack", style: "margin-top:8px", role: "group", "aria-label": "Found by words" },
      h("div", {}, h("b", {}, `${many ? `${names.slice(0, -1).join(", ")} and ${names.at(-1)}` : names[0]}`), ` ${many ? "were" : "was"} found by ${many ? "their names" : "its name"}, not clicked. Do the names in the picture stand at the right things?`),
      h("div", { class: "row" },
        button("Yes", () => { settled.add(key); show(); }, { class: "b small" }),
        button("No, let me click", () => mark({ kind: "object", name: data.guessed[0] }), { class: "b small", title: "Select a thing below the photo, then click on the right place" })));
  }

  const busy = () => Boolean(value("run")?.busy);
  const doubtful = () => data.doubts.length + data.loose.length > 0 || Boolean(guessed());

  // A shape that covers too little of what was cut out.
  function loose() {
    return data.loose.filter((one) => !data.doubts.some((other) => other.name === one.name)).map((one) => {
      const name = one.name.replaceAll("_", " ");
      return h("div", { class: "strip warn stack", style: "margin-top:8px", role: "group", "aria-label": `Loose fit of ${name}` },
        h("div", {}, "The shape of ", h("b", {}, name), ` covers ${one.percent} % of what was cut out.`),
        h("div", { class: "row" }, button("Try its next shape", () => { send({ do: "select", kind: "object", name: one.name }); send({ do: "form", name: one.name, kind: null }); }, { class: "b small", title: "Another kind of shape (S)" }), button("Look at its masks", () => mark({ kind: "object", name: one.name }), { class: "b small" })));
    });
  }

  // What is filled in behind a thing goes over another one like it: it has to be marked as well.
  let over = {}, asked = "", ticket = 0;
  const lookAround = (photo) => {
    const key = photo?.seen && !photo.readOnly ? `${photo.session} ${photo.objects.map((one) => one.path.length).join(" ")}` : "";
    if (key === asked) return;
    [asked, over] = [key, {}];
    if (key) send({ do: "like", ticket: ++ticket });
  };
  on("photo", lookAround);
  on("like", (told) => { if (told.name === "" && told.ticket === ticket) { over = told.found || {}; show(); } });

  const covering = () => (data.readOnly ? [] : Object.entries(over).map(([name, boxes]) => {
    const word = name.replaceAll("_", " ");
    return h("div", { class: "strip warn stack", style: "margin-top:8px", role: "group", "aria-label": `Like ${word}` },
      h("div", {}, "Where ", h("b", {}, word), ` moves away, the picture behind it goes over ${say(boxes.length, "thing")} that ${boxes.length === 1 ? "looks" : "look"} like it.`),
      h("div", { class: "row" }, button("Mark similar things", () => { over = {}; show(); send({ do: "alike", name, boxes }); }, { class: "b small", title: "They are cut out as well, and stay where they are unless something hits them" }), button("Leave it", () => { delete over[name]; show(); }, { class: "b small" })));
  }));

  // A mask that is more likely wrong than right makes everything after it doubtful.
  function doubted() {
    if (data.readOnly || data.guessed.length) return null;
    return [...covering(), ...loose(), ...data.doubts.map((one) => {
      const name = one.name.replaceAll("_", " ");
      const camera = one.kind === "camera";
      const fix = camera
        ? [button("Draw the horizon instead", () => { showPhoto(); dispatchEvent(new CustomEvent("photo-tool", { detail: "horizon" })); }, { class: "b small" })]
        : [button("Look at its masks", () => mark({ kind: "object", name: one.name }), { class: "b small", title: "Choose one of the masks with the keys 1 to 4, or draw a box" }),
          button("It is right", () => send({ do: "mask", name: one.name, grounding: { ...one.grounding, settled: true } }), { class: "b small" })];
      return h("div", { class: "strip warn stack", style: "margin-top:8px", role: "group", "aria-label": camera ? "Doubtful camera" : `Doubtful mask of ${name}` },
        h("div", {}, camera ? h("b", {}, "How was the camera held?") : ["Is the whole of ", h("b", {}, name), " cut out, and nothing else?"], ` (${one.percent} % sure)${camera ? ": choose what is most like it." : ""}`),
        camera && data.photo ? cameras(data.photo, (row) => send({ do: "horizon", row, roll: 0 })) : null,
        h("div", { class: "row" }, fix));
    })];
  }

  function row(r) {
    const words = r.stage === "reconstruction" ? (r.verdict === "failed" ? "scene does not match" : r.shown && doubtful() ? "scene to be checked" : "scene matches the photo") : r.checks ? (r.unseen && r.realised === r.checks ? r.unseen : `${r.realised} of ${r.checks} hold`) : r.stage ? "nothing is demanded" : "in progress";
    return h("div", { class: "row", role: "listitem", key: r.id, style: `padding-left:${r.depth * 14}px;gap:2px` },
      h("button", { class: `r grow${r.shown ? " on" : ""}${r.onPath ? "" : " off"}`, type: "button", title: r.factor ? `Proposed to change: ${r.factor}` : "", onclick: () => send({ do: "round", id: r.head ? null : r.id }) },
        h("span", { class: `dot ${r.verdict}` }, MARK[r.verdict]),
        h("span", { class: "grow" }, h("b", {}, `Round ${r.number}`), h("span", { class: "muted", title: r.checks ? `${r.realised} of ${r.checks} demands of the sentence hold${r.unseen ? `; a viewer sees it so: ${r.unseen}` : ""}` : "" }, ` · ${words}`), r.overruled ? h("span", { class: "muted" }, " · overruled") : null),
        r.decided ? h("span", { class: "chip", title: `by ${r.by}` }, r.decided) : null,
        r.best && data.rounds.length > 1 ? h("span", { class: "chip ok" }, "best") : null),
      r.shown || data.rounds.length < 2 ? null
        : h("button", { class: "b quiet small", type: "button", title: "Compare with the round on view", "aria-label": `Compare with round ${r.number}`, onclick: () => send({ do: "compare", round: data.compare && data.compare.id === r.id ? null : r.id }) }, "⇄"));
  }

  function verdict(shown) {
    if (data.draft) return h("div", { class: "head" }, "Your edits, measured");
    if (data.turn === "verifier") return h("div", { class: "head" }, `Measured: ${SAYS[shown.stage][Number(shown.machine)]}`);
    if (shown.verdict === "open") return shown.stage ? h("div", { style: "margin-top:14px" }, h("p", { class: "title row" }, doubtful() ? h("span", { class: "dot warn" }, "!") : null, doubtful() ? "The scene may not match the photo" : "The scene matches the photo"), h("p", { class: "muted" }, doubtful() ? "Look at what is doubted below; then Start." : "Next the event is run in it and measured.")) : null;
    const good = shown.verdict === "ok";
    const stage = shown.stage === "reconstruction";
    const unseen = !stage && !shown.override && data.checks.every((c) => c.ok || c.part || c.group === "view");
    const sure = !data.doubts.some((one) => one.kind === "mask");
    const told = !data.notUnderstood.length && !data.untested.length;
    const said = good ? `The event happens${sure ? "" : ", if the masks are right"}${told ? "" : ", as far as it is tested"}` : stage ? "The scene does not match the photo" : unseen ? `It happens, but: ${shown.unseen || "not well seen"}` : "The event does not happen yet";
    return h("div", { style: "margin-top:14px" },
      h("div", { class: "row" },
        h("span", { class: "title grow" }, said),
        data.readOnly ? null : h("button", { class: "link", type: "button", "aria-expanded": String(overruling === shown.id), title: "Overrule what was measured: say yourself whether it happens", onclick: toggle }, "I disagree")),
      data.credit?.known ? null : changes(shown),
      credit(data.credit, busy()),
      shown.override ? h("p", { class: "muted" }, `Your verdict: ${SAYS[shown.stage][Number(shown.override.passed)]}${shown.override.words ? ` (“${shown.override.words}”)` : ""}. The checks said: ${SAYS[shown.stage][Number(shown.machine)]}.`) : null,
      shown.contradiction ? h("div", { class: "strip warn", style: "margin-top:6px" }, h("b", {}, "Verdict and measurement disagree. "), shown.contradiction) : null,
      overruling === shown.id && !data.readOnly ? h("div", { class: "stack card", style: "margin-top:8px" },
        h("p", { class: "muted" }, "Your verdict is kept beside the measured one."),
        h("textarea", { rows: 2, placeholder: "Why? (optional)", "data-focus": true, "aria-label": "Your reason", oninput: (e) => (words = e.target.value) }),
        h("div", { class: "row" },
          button("It happens", () => { send({ do: "overrule", passed: true, words }); toggle(); }, { class: "b wide" }),
          button("It does not", () => { send({ do: "overrule", passed: false, words }); toggle(); }, { class: "b wide" }))) : null);
  }

  // What this round has other than the one before it.
  function changes(shown) {
    if (!shown.changes.length) return null;
    return h("p", { class: "muted changes", key: `changes-${shown.id}` }, h("b", {}, "Changed: "), inShort(shown.changes, 3));
  }

  function why(shown) {
    // What stands in the checklist already is not said again.
    const said = new Set(data.checks.filter((c) => !c.ok).flatMap((c) => [c.text, c.told]));
    const fresh = (one) => !said.has(one.text) && said.add(one.text);
    const notes = data.draft ? [] : shown.diagnosis.filter(fresh);
    const findings = shown.findings.filter((f) => !f.ok && fresh(f));
    const criteria = data.draft ? [] : shown.criteria;
    const clauses = data.draft ? [] : shown.clauses;
    if (!notes.length && !findings.length && !criteria.length && !clauses.length) return null;
    return h("div", { class: "section" },
      notes.length || findings.length ? h("div", { class: "head" }, shown.verdict === "failed" ? "What went wrong" : "Good to know") : null,
      h("ul", { class: "stack" },
        notes.map((one) => h("li", {}, one.text.replace(` ${moment(one.frame)}`, ""), " ", one.frame === null ? null : h("button", { class: "link num", type: "button", onclick: () => scrub(one.frame) }, moment(one.frame)))),
        findings.map((one) => h("li", {}, one.text))),
      clauses.length ? [h("div", { class: "head" }, shown.judge ? `What ${shown.judge} saw` : "Clause by clause"), h("ul", { class: "stack", "aria-label": "Clause by clause" }, clauses.map((one) => h("li", { class: "row top" }, h("span", { class: `dot ${one.ok ? "ok" : "bad"}` }, one.ok ? "✓" : "✕"), h("span", {}, h("b", {}, one.name), one.reason ? h("span", { class: "muted" }, `: ${one.reason}`) : null))))] : null,
      criteria.length ? [h("div", { class: "head" }, "Judged by"), h("ul", { class: "stack", "aria-label": "Judged by" }, criteria.map((one) => h("li", { class: "row top" }, h("span", { class: `dot ${one.ok ? "ok" : "bad"}` }, one.ok ? "✓" : "✕"), h("span", {}, one.name, h("span", { class: "muted" }, ` ${one.ok ? "Yes" : "No"}${one.ok || !one.reason ? "" : `: ${one.reason}`}`)))))] : null);
  }

  function comparison(c) {
    const side = (one) => h("span", { class: "num", style: one ? `color:var(--${one.ok ? "ok" : "bad"})` : "" }, one ? `${one.ok ? "✓" : "✕"} ${one.measured}` : "–");
    return h("div", { class: "section card", "data-compare": true },
      h("div", { class: "head" }, `Compared with round ${c.number}`, h("button", { class: "link push", type: "button", onclick: showPlots }, "Curves"), h("button", { class: "link", type: "button", onclick: () => send({ do: "compare", round: null }) }, "Close")),
      h("div", { class: "sides" },
        h("span", { class: "faint" }, `round ${c.number}`), h("span", { class: "faint" }, "on view"),
        c.rows.map((one) => [h("span", { class: "what" }, one.text), side(one.there), side(one.here)])),
      c.diff.length ? h("div", { class: "diff", role: "group", tabindex: "0", "aria-label": `What changed from round ${c.number}`, style: "margin-top:8px" }, c.diff.map((one) => h("div", { class: one.kind }, `${{ add: "+ ", del: "− " }[one.kind] || ""}${one.text}`))) : h("p", { class: "muted" }, "Both rounds ran the same program."));
  }

  function memory() {
    return h("div", { class: "section" },
      h("div", { class: "head" }, "Kept in mind"),
      h("ul", { class: "stack" },
        data.hints.map((one) => h("li", { class: "muted" }, `Hint: ${one}`)),
        data.kept.map(({ path, what }) => h("li", { class: "row" }, icon("pin"), h("span", { class: "grow" }, what), button("Unpin", () => send({ do: "pin", path, on: false }), { class: "b quiet small" })))));
  }

  // Escape closes whatever form is open; a form never goes along into another session.
  addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || document.querySelector(".shade")) return;
    const closed = proposal.close() || checklist.close() || (overruling && (toggle(), true));
    if (!closed) return;
    event.preventDefault();
    event.stopPropagation();
  }, true);
  let session = null, worked = false;
  on("run", (run) => {
    if (worked !== busy()) { worked = busy(); show(); }
    if (run.session === session) return;
    session = run.session;
    [overruling, words] = ["", ""];
    settled.clear();
    proposal.forget();
    checklist.close();
    show();
  });
  on("timeline", show); // its seconds are spoken of here
  let compared = null;
  on("rounds", (next) => {
    data = next;
    show();
    // What is compared shows itself.
    const now = next.compare?.id || null;
    if (now && now !== compared) { showRounds(); host.querySelector("[data-compare]")?.scrollIntoView({ block: "nearest" }); }
    compared = now;
  });
}

