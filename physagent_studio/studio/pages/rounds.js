// Rounds: the history, the checklist, and the decision on the proposal.

import { button, draw, h, icon, iconButton, say } from "./dom.js";
import { edit, on, scrub, send } from "./wire.js";

const MARK = { ok: "✓", failed: "✕", open: "…" };

export function startRounds(host) {
  let data = null;
  let proposal = null; // id of the proposal that the local state belongs to
  let off = new Set(); // hunks that are not taken
  let values = new Map(); // "hunk/edit" → the person's own value
  let mode = ""; // "", edit, override, reject, hint, overrule
  let text = "";
  let unfolded = false;

  const show = () => data && draw(host, page());
  const set = (next) => { mode = mode === next ? "" : next; text = ""; show(); focus(); };
  const focus = () => setTimeout(() => host.querySelector("[data-focus]")?.focus(), 0);

  function page() {
    const shown = data.shown;
    if (!data.rounds.length) return [h("p", { class: "muted" }, "Rounds appear here: each is one try at making the sentence happen, with what was measured and what to change next."), checklist()];
    return [
      h("div", { class: "rounds", role: "list", "aria-label": "History" }, data.rounds.map(row)),
      data.readOnly ? h("div", { class: "strip warn stack", style: "margin-top:8px" },
        h("div", {}, `Round ${shown.number} is open read-only.`),
        h("div", { class: "row" }, button("Go on from here", () => send({ do: "fork", id: shown.id }), { class: "b small" }),
          button("Back to the current round", () => send({ do: "round", id: null }), { class: "b small" }))) : null,
      shown ? verdict(shown) : null,
      checklist(),
      data.notUnderstood.length ? h("div", { class: "strip warn", style: "margin-top:8px" }, "Not understood: ", data.notUnderstood.join("; ")) : null,
      data.untested.length ? h("div", { class: "strip warn", style: "margin-top:8px" }, "Nothing tests: ", data.untested.join("; ")) : null,
      shown ? why(shown) : null,
      data.proposal ? card(data.proposal) : null,
      data.compare ? comparison(data.compare) : null,
      data.pinned.length || data.hints.length ? memory() : null,
    ];
  }

  function row(r) {
    const words = r.stage === "reconstruction" ? "the scene does not match yet" : r.checks ? `${r.realised} of ${r.checks} checks` : "in progress";
    return h("div", { class: "row", role: "listitem", key: r.id, style: `padding-left:${r.depth * 14}px;gap:2px` },
      h("button", { class: `r grow${r.shown ? " on" : ""}${r.onPath ? "" : " off"}`, type: "button", title: r.factor ? `Proposed to change: ${r.factor}` : "", onclick: () => send({ do: "round", id: r.head ? null : r.id }) },
        h("span", { class: `dot ${r.verdict}` }, MARK[r.verdict]),
        h("span", { class: "grow" }, h("b", {}, `Round ${r.number}`), h("span", { class: "muted" }, ` · ${words}`), r.overruled ? h("span", { class: "muted" }, " · overruled") : null),
        r.decided ? h("span", { class: "chip", title: `by ${r.by}` }, r.decided) : null,
        r.best && data.rounds.length > 1 ? h("span", { class: "chip ok" }, "best") : null),
      r.shown || data.rounds.length < 2 ? null
        : h("button", { class: "b quiet small", type: "button", title: "Compare with the round on view", "aria-label": `Compare with round ${r.number}`, onclick: () => send({ do: "compare", round: data.compare && data.compare.id === r.id ? null : r.id }) }, "⇄"));
  }

  function verdict(shown) {
    if (shown.verdict === "open" || data.draft) return data.draft ? h("div", { class: "head" }, "Your edits, measured") : null;
    const good = shown.verdict === "ok";
    const stage = shown.stage === "reconstruction";
    const words = good ? "The event happens" : stage ? "The scene does not match the photo" : "The event does not happen yet";
    return h("div", { style: "margin-top:14px" },
      h("div", { class: "row" },
        h("span", { class: "title grow" }, words),
        data.readOnly ? null : h("button", { class: "link", type: "button", onclick: () => set("overrule") }, "Overrule")),
      shown.override ? h("p", { class: "muted" }, `Your verdict: ${shown.override.passed ? "it happens" : "it does not"}${shown.override.words ? ` (“${shown.override.words}”)` : ""}. The checks said ${shown.machine ? "it happens" : "it does not"}.`) : null,
      mode === "overrule" ? h("div", { class: "stack card", style: "margin-top:8px" },
        h("p", { class: "muted" }, "Your verdict is kept beside the measured one."),
        h("textarea", { rows: 2, placeholder: "Why? (optional)", "data-focus": true, "aria-label": "Your reason", oninput: (e) => (text = e.target.value) }),
        h("div", { class: "row" },
          button("It happens", () => { send({ do: "overrule", passed: true, words: text }); set(""); }, { class: "b wide" }),
          button("It does not", () => { send({ do: "overrule", passed: false, words: text }); set(""); }, { class: "b wide" }))) : null);
  }

  const STATEMENTS = [
    ["moves", "moves", { distance: 0.1 }], ["touches", "contacts", { other: 1 }], ["falls over", "topples", {}], ["stays", "stays", {}], ["falls", "falls", {}],
    ["ends on", "rests_on", { other: 1 }], ["stops", "stops", {}], ["leaves", "leaves", { other: 1 }], ["turns", "rotates", {}],
  ];

  // A new line of the checklist: who does what.
  function demand() {
    const names = data.names;
    if (!names.objects.length || data.readOnly) return null;
    if (mode !== "demand") return h("button", { class: "link", type: "button", onclick: () => set("demand") }, "+ Demand something");
    const pick = (list, label) => h("select", { "aria-label": label, class: "pick" }, list.map((one) => h("option", { value: Array.isArray(one) ? one[1] : one }, Array.isArray(one) ? one[0] : one.replaceAll("_", " "))));
    const add = (event) => {
      const [subject, kind, other] = [...event.target.closest(".card").querySelectorAll(".pick")].map((one) => one.value);
      const wanted = STATEMENTS.find((one) => one[1] === kind)[2];
      const item = { id: `${subject}_${kind}_${names.statements.length + 1}`, kind, subject, ...wanted };
      if (wanted.other) item.other = other;
      edit([{ op: "add", path: "contract.statements", item }], "demanded by hand");
      set("demand");
    };
    return h("div", { class: "card stack", style: "margin-top:6px" }, h("div", { class: "row wrap" }, pick(names.objects, "Who"), pick(STATEMENTS, "Does what"), pick(names.places, "With what")), button("Add to the checklist", add, { class: "b wide" }));
  }

  function checklist() {
    if (!data.checks.length) return data.names ? demand() : null;
    const contract = data.checks.filter((c) => !c.always);
    const always = data.checks.filter((c) => c.always);
    const broken = always.filter((c) => !c.ok);
    // While there is something to decide, what holds is folded away, so that the proposal is near.
    const holds = contract.filter((c) => c.ok);
    const fold = Boolean(data.proposal) && !unfolded && holds.length > 0;
    return h("div", {},
      h("div", { class: "head" }, "Checklist", h("span", { class: "push num" }, `${holds.length} of ${contract.length}`)),
      h("div", { role: "list", "aria-label": "Checklist" }, (fold ? contract.filter((c) => !c.ok) : contract).map(check)),
      data.proposal && holds.length ? h("p", { style: "padding:4px" }, h("button", { class: "link", type: "button", onclick: () => { unfolded = !unfolded; show(); } }, fold ? `${say(holds.length, "demand")} ${holds.length === 1 ? "holds" : "hold"}: show` : "Show only what fails")) : null,
      broken.map(check),
      fold ? null : demand(),
      fold ? null : h("p", { class: "faint", style: "padding:4px" }, broken.length ? "" : `Physics holds: ${say(always.length, "check")} passed.`));
  }

  function check(c, at, all) {
    const jump = c.frame === null ? null : h("button", { class: "link num", type: "button", title: "Show this moment", onclick: () => scrub(c.frame) }, `frame ${c.frame}`);
    const first = c.clause && (!at || all[at - 1].clause !== c.clause);
    return [first ? h("div", { class: "clause", key: `clause-${c.id}` }, `“${c.clause}”`) : null,
      h("div", { class: "check", role: "listitem", key: c.id },
        h("span", { class: `dot ${c.ok ? "ok" : "bad"}`, title: c.ok ? "holds" : "does not hold" }, c.ok ? "✓" : "✕"),
        c.always ? h("span", { title: c.found }, c.text) : h("button", { class: "plain", type: "button", title: c.found || "Change what is demanded", onclick: () => send({ do: "select", kind: "statement", name: c.id }) }, c.text),
        h("span", { class: "fig num" },
          c.measured ? h("span", {}, c.measured) : null, jump,
          c.predicted && c.predicted.ok !== c.ok ? h("span", { class: c.predicted.ok ? "chip ok" : "chip bad", title: c.predicted.measured }, `with the repair: ${c.predicted.ok ? "holds" : "fails"}`) : null))];
  }

  function why(shown) {
    const notes = data.draft ? [] : shown.diagnosis;
    const findings = shown.findings.filter((f) => !f.ok);
    const criteria = data.draft ? [] : shown.criteria;
    if (!notes.length && !findings.length && !criteria.length) return null;
    return h("div", {},
      notes.length || findings.length ? h("div", { class: "head" }, "What went wrong") : null,
      h("ul", { class: "stack" },
        notes.map((one) => h("li", {}, one.text, " ", one.frame === null ? null : h("button", { class: "link num", type: "button", onclick: () => scrub(one.frame) }, `frame ${one.frame}`))),
        findings.map((one) => h("li", {}, one.text))),
      criteria.length ? h("div", { class: "row wrap", style: "margin-top:8px;gap:4px" }, criteria.map((one) => h("span", { class: `chip ${one.ok ? "ok" : "bad"}`, title: one.reason }, `${one.ok ? "✓" : "✕"} ${one.name}`))) : null);
  }

  // --- the proposal -------------------------------------------------------------------------

  const edited = () => values.size > 0;
  const taken = (p) => p.hunks.filter((one) => !off.has(one.id));

  function decided(p) {
    return taken(p).flatMap((hunk) => hunk.edits.map((one, at) => (values.has(`${hunk.id}/${at}`) ? { ...one, value: values.get(`${hunk.id}/${at}`) } : one)));
  }

  function accept(p) {
    const whole = off.size === 0;
    const decision = { do: "decide", proposal: p.id, reason: "" };
    if (edited()) send({ ...decision, kind: "edit", edits: decided(p) });
    else if (whole) send({ ...decision, kind: "accept" });
    else send({ ...decision, kind: "accept_hunks", hunks: taken(p).map((one) => one.id) });
  }

  function card(p) {
    if (p.id !== proposal) { proposal = p.id; off = new Set(); values = new Map(); mode = ""; text = ""; }
    const label = edited() ? "Accept edited" : off.size ? "Accept selected" : "Accept";
    return h("div", { class: "card accent stack", key: `proposal-${p.id}`, style: "margin-top:16px", "aria-label": "Proposal", role: "group" },
      h("div", { class: "row wrap", style: "gap:4px 8px" }, h("span", { class: "title grow", style: "white-space:nowrap" }, "Proposed repair"), h("span", { class: "chip accent clip", title: p.factor }, p.factor)),
      h("p", {}, p.rationale),
      p.question ? h("div", { class: "strip warn" }, p.question) : null,
      p.verified ? h("div", { class: "strip warn" }, "This changes something that was already verified.") : null,
      p.preview ? outcome(p.preview) : null,
      p.hunks.map((one) => hunk(p, one)),
      h("div", { class: "row muted", style: "font-size:12px" }, h("span", {}, `Confidence ${p.confidence} %`), h("span", { class: "grow bar" }, h("i", { style: `width:${p.confidence}%` })), p.simulations ? h("span", { class: "num" }, say(p.simulations, "trial")) : null),
      h("div", { class: "row" },
        button(label, () => accept(p), { class: "b main wide", disabled: taken(p).length === 0 && p.hunks.length > 0, title: "Accept (A)", "data-act": "accept" }),
        button("Edit", () => set("edit"), { "aria-pressed": String(mode === "edit"), title: "Change the numbers, then accept (E)", "data-act": "edit" }),
        button("Reject", () => set("reject"), { class: "b bad", "aria-pressed": String(mode === "reject"), title: "The planner tries again, knowing why (X)", "data-act": "reject" })),
      h("div", { class: "row wrap", style: "gap:2px" },
        button("Override", () => { set("override"); }, { class: "b quiet", "aria-pressed": String(mode === "override"), title: "Your own edits in its place" }),
        button("Hint", () => set("hint"), { class: "b quiet", "aria-pressed": String(mode === "hint"), title: "Tell the planner something" }),
        button("Skip", () => send({ do: "decide", kind: "skip", proposal: p.id }), { class: "b quiet", title: "Go on without this repair" }),
        button("Stop", () => send({ do: "decide", kind: "stop", proposal: p.id }), { class: "b quiet", title: "End here, keep the best round" })),
      form(p));
  }

  function outcome(preview) {
    if (preview.problem) return h("div", { class: "strip warn" }, preview.problem);
    return h("div", { class: preview.passed ? "strip ok" : "strip" }, preview.passed ? "Tried out: the event happens." : `Tried out: ${preview.ok} of ${preview.of} checks hold.`, h("span", { class: "muted" }, " Its path is drawn in green."));
  }

  function hunk(p, one) {
    const on = !off.has(one.id);
    return h("div", { class: on ? "hunk" : "hunk off", key: one.id },
      h("label", { class: "row top" },
        h("input", { type: "checkbox", checked: on, "aria-label": `Take: ${one.summary}`, onchange: () => { if (on) off.add(one.id); else off.delete(one.id); show(); } }),
        h("span", { class: "grow" }, one.summary)),
      one.rows.map((change, at) => changed(one, change, at)));
  }

  function changed(one, change, at) {
    const key = `${one.id}/${at}`;
    const now = values.has(key) ? values.get(key) : change.value;
    return h("div", { class: "change", key },
      h("span", { class: "clip", title: change.path }, change.what),
      h("span", { class: "row", style: "gap:4px" },
        change.op === "set" && mode !== "edit" ? [h("span", { class: "was num" }, change.before), "→", h("span", { class: "now num" }, values.has(key) ? compact(now) : change.after), h("span", { class: "faint" }, change.unit)] : change.op === "set" ? h("span", { class: "faint num" }, `was ${change.before} ${change.unit}`) : h("span", { class: "now clip" }, change.after),
        change.op === "set" ? iconButton("pin", "Pin: never change this", () => send({ do: "pin", path: change.path, on: !data.pinned.includes(change.path) }), { "aria-pressed": String(data.pinned.includes(change.path)), style: "width:20px;height:20px" }) : null),
      mode === "edit" && change.op === "set" ? h("div", { class: "nums" }, numbers(now, [], (next) => { values.set(key, next); show(); }, change)) : null);
  }

  // One field per number in a value, however deep it lies.
  function numbers(value, trail, changed, change) {
    const put = (raw) => {
      const number = Number(raw);
      if (raw.trim() === "" || !Number.isFinite(number)) return false;
      changed(number);
      return true;
    };
    if (typeof value === "number") {
      const label = [change.what, ...trail].join(" ");
      return h("input", { type: "text", inputmode: "decimal", "data-focus": true, value: String(value), "aria-label": label, title: label,
        oninput: (e) => e.target.classList.toggle("wrong", !put(e.target.value)) });
    }
    if (Array.isArray(value)) return value.map((part, at) => numbers(part, [...trail, "xyz"[at] || String(at)], (next) => changed(value.map((old, i) => (i === at ? next : old))), change));
    if (value && typeof value === "object") {
      return Object.entries(value).filter(([, part]) => typeof part === "number" || Array.isArray(part)).map(([name, part]) =>
        h("label", { class: "row", style: "gap:4px" }, h("span", { class: "faint" }, name.replaceAll("_", " ")), numbers(part, [...trail, name], (next) => changed({ ...value, [name]: next }), change)));
    }
    return h("input", { type: "text", value: String(value), "aria-label": change.what, oninput: (e) => changed(e.target.value) });
  }

  function form(p) {
    if (mode === "reject" || mode === "hint") {
      const reject = mode === "reject";
      const go = () => { send({ do: "decide", kind: mode, proposal: p.id, reason: text }); set(""); };
      return h("div", { class: "stack" },
        h("textarea", { rows: 2, "data-focus": true, "aria-label": reject ? "Reason" : "Hint", placeholder: reject ? "Why not? The planner will know." : "What should the planner know? For example: it should arrive later", oninput: (e) => (text = e.target.value), onkeydown: (e) => { if (e.key === "Enter" && (e.ctrlKey || e.metaKey)) go(); } }),
        button(reject ? "Reject and try again" : "Give the hint", go, { class: "b wide" }));
    }
    if (mode === "override") {
      if (!text) text = p.hunks.flatMap((one) => one.edits).filter((one) => one.op === "set").map((one) => `${one.path}: ${JSON.stringify(one.value)}`).join("\n");
      return h("div", { class: "stack" },
        h("p", { class: "muted" }, "Your own changes, one on each line: the field, a colon, the value."),
        h("textarea", { class: "mono", rows: 4, "data-focus": true, "aria-label": "Your own changes", value: text, oninput: (e) => (text = e.target.value) }),
        button("Use mine instead", () => override(p), { class: "b wide" }));
    }
    return null;
  }

  function override(p) {
    const edits = [];
    for (const line of text.split("\n").map((one) => one.trim()).filter(Boolean)) {
      const at = line.indexOf(":");
      let value = line.slice(at + 1).trim();
      try { value = JSON.parse(value); } catch { /* a word stands for itself */ }
      edits.push({ op: "set", path: line.slice(0, at).trim(), value });
    }
    send({ do: "decide", kind: "override", proposal: p.id, edits });
  }

  function comparison(c) {
    const side = (one) => (one ? h("span", { class: "num", style: `color:var(--${one.ok ? "ok" : "bad"})` }, `${one.ok ? "✓" : "✕"} ${one.measured}`) : "–");
    return h("div", {},
      h("div", { class: "head" }, `Compared with round ${c.number}`, h("button", { class: "link push", type: "button", onclick: () => send({ do: "compare", round: null }) }, "Close")),
      h("div", { style: "display:grid;grid-template-columns:1fr auto auto;gap:3px 12px;font-size:12px" },
        h("span", {}), h("span", { class: "faint" }, `round ${c.number}`), h("span", { class: "faint" }, "on view"),
        c.rows.map((one) => [h("span", {}, one.text), side(one.there), side(one.here)])),
      c.diff.length ? h("div", { class: "diff", style: "margin-top:8px" }, c.diff.map((line) => h("div", { class: line.startsWith("+") ? "add" : line.startsWith("-") ? "del" : line.startsWith("@") ? "at" : "" }, line || " "))) : h("p", { class: "muted" }, "Both rounds ran the same program."));
  }

  function memory() {
    return h("div", {},
      h("div", { class: "head" }, "Kept in mind"),
      h("ul", { class: "stack" },
        data.hints.map((one) => h("li", { class: "muted" }, `Hint: ${one}`)),
        data.pinned.map((path) => h("li", { class: "row" }, icon("pin"), h("span", { class: "grow clip mono", title: path }, path), button("Unpin", () => send({ do: "pin", path, on: false }), { class: "b quiet small" })))));
  }

  on("rounds", (next) => { data = next; show(); });
}

const compact = (value) => (typeof value === "number" ? String(Number(value.toPrecision(4))) : Array.isArray(value) ? `(${value.map(compact).join(", ")})` : value && typeof value === "object" ? Object.entries(value).filter(([, part]) => part !== null).map(([name, part]) => `${name} ${compact(part)}`).join(", ") : String(value));
