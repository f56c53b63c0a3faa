// Proposal: the repair, or a gentler way, hunk by hunk, and every way to decide on it.

import { button, h, iconButton, say } from "./dom.js";
import { on, send as post, value } from "./wire.js";

export function makeProposal(show, focus, mark) {
  let pinned = [];
  let proposal = null; // id of the proposal that the local state belongs to
  let off = new Set(); // hunks that are not taken
  let values = new Map(); // "hunk/edit" → the person's own value
  let mode = ""; // "", edit, override, reject, hint
  let text = "";
  let answer = ""; // to the planner's question

  // From the click until the work that it asked for has begun and ended, there is nothing to decide.
  let sent = "";
  const DONE = { accept: "Accepted", accept_hunks: "Accepted in part", edit: "Accepted with your numbers", override: "Your changes are taken", reject: "Rejected", hint: "The planner knows", skip: "Skipped", stop: "Stopped" };
  const over = () => { if (sent && !value("run")?.busy) { sent = ""; show(); } };
  const send = (intent) => {
    const decides = intent.do === "decide";
    if (decides && sent) return;
    if (!post(intent) || !decides) return;
    sent = intent.kind;
    setTimeout(over, 1500); // what is refused starts no work
    show();
  };
  on("run", over);
  // What was refused was not taken, and is there to be decided anew.
  const refused = () => { if (sent) { sent = ""; show(); } };
  on("say", (notice) => { if (notice.level === "error") refused(); });
  let told = 0; // the newest of the errors that last
  on("notices", (all) => {
    const newest = Math.max(0, ...all.filter((one) => one.level === "error").map((one) => one.id));
    if (newest > told) refused();
    told = newest;
  });

  const set = (next) => { mode = mode === next ? "" : next; text = ""; show(); focus(); };

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

  function card(p, pins, draft) {
    pinned = pins;
    if (p.id !== proposal) { proposal = p.id; off = new Set(); values = new Map(); mode = ""; text = ""; answer = ""; }
    const label = edited() ? "Accept edited" : off.size ? "Accept selected" : "Accept";
    return h("div", { class: "card accent stack", key: `proposal-${p.id}`, style: "margin-top:16px", "aria-label": "Proposal", role: "group" },
      h("div", { class: "row wrap", style: "gap:4px 8px" }, h("span", { class: "title", style: "white-space:nowrap;flex:1 0 auto" }, p.gentler ? "A gentler way" : p.hunks.length ? "Proposed repair" : "No repair found"), p.hunks.length && !p.gentler ? h("span", { class: "chip accent clip", title: p.factor }, p.factor) : null),
      p.gentler ? h("p", { class: "muted" }, "The event happens as it is. This would make it happen more gently.") : null,
      h("p", {}, p.rationale),
      p.question ? asked(p) : null,
      p.verified ? h("div", { class: "strip warn" }, "This changes something that was already verified.") : null,
      p.preview && p.hunks.length ? outcome(p.preview) : null,
      p.hunks.map((one) => hunk(p, one)),
      !p.hunks.length ? null : h("div", { class: "row muted", style: "font-size:12px" }, h("span", {}, `Confidence ${p.confidence} %`), h("span", { class: "grow bar" }, h("i", { style: `width:${p.confidence}%` })), p.simulations ? h("span", { class: "num" }, say(p.simulations, "trial")) : null),
      h("div", { class: sent ? "decide off" : "decide", "aria-disabled": sent ? "true" : null },
      draft ? h("div", { class: "strip warn" }, "You have edits of your own. Deciding here leaves them behind; undo brings them back.") : null,
      sent ? h("div", { class: "strip", role: "status" }, `${p.gentler && sent === "skip" ? "Kept as it is" : DONE[sent]}; what follows is worked out…`) : null,
      h("div", { class: "row" },
        button(label, () => accept(p), { class: "b main wide", disabled: taken(p).length === 0, title: "Accept (A)", "data-act": "accept" }),
        button("Edit", () => set("edit"), { "aria-pressed": String(mode === "edit"), title: "Change the numbers, then accept (E)", "data-act": "edit" }),
        p.gentler ? button("Keep as it is", () => send({ do: "decide", kind: "skip", proposal: p.id }), { title: "Nothing is changed (X)", "data-act": "reject" })
          : button("Reject", () => set("reject"), { class: "b bad", "aria-pressed": String(mode === "reject"), title: "The planner tries again, knowing why (X)", "data-act": "reject" })),
      p.gentler ? null : h("div", { class: "row wrap", style: "gap:2px" },
        button("Override", () => { set("override"); }, { class: "b quiet", "aria-pressed": String(mode === "override"), title: "Your own edits in its place" }),
        button("Hint", () => set("hint"), { class: "b quiet", "aria-pressed": String(mode === "hint"), title: "Tell the planner something" }),
        button("Skip", () => send({ do: "decide", kind: "skip", proposal: p.id }), { class: "b quiet", title: "Go on without this repair" }),
        button("Stop", () => send({ do: "decide", kind: "stop", proposal: p.id }), { class: "b quiet", title: "End here, keep the best round" }))),
      form(p));
  }

  // What the planner wants to know; the answer goes to it as a hint.
  function asked(p) {
    const go = () => { if (answer.trim()) send({ do: "decide", kind: "hint", proposal: p.id, reason: answer.trim() }); };
    return h("div", { class: "strip warn stack", key: `question-${p.id}` }, h("div", {}, h("b", {}, "The planner asks: "), p.question),
      p.about ? button(`Mark ${p.about.name.replaceAll("_", " ")} in the photo`, () => mark(p.about), { class: "b small main" }) : null,
      h("textarea", { rows: 2, "aria-label": "Your answer", placeholder: p.about ? "Or answer in words" : "Your answer", oninput: (e) => (answer = e.target.value), onkeydown: (e) => { if (e.key === "Enter" && (e.ctrlKey || e.metaKey)) go(); } }),
      button("Answer", go, { class: "b small" }));
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
        change.op === "set" && (mode !== "edit" || change.fixed) ? [change.value === null && change.before.length > 20 ? null : [h("span", { class: "was num" }, change.before), "→"], h("span", { class: "now num" }, values.has(key) ? compact(now) : change.after), h("span", { class: "faint" }, change.unit)] : change.op === "set" ? h("span", { class: "faint num" }, `was ${change.before} ${change.unit}`) : h("span", { class: "now clip" }, change.after),
        change.op === "set" ? iconButton("pin", "Pin: never change this", () => send({ do: "pin", path: change.path, on: !pinned.includes(change.path) }), { "aria-pressed": String(pinned.includes(change.path)), style: "width:20px;height:20px" }) : null),
      mode === "edit" && change.op === "set" && !change.fixed ? h("div", { class: "nums" }, numbers(now, [], (next) => { values.set(key, next); show(); }, change)) : null);
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

  return card;
}

const compact = (value) => (typeof value === "number" ? String(Number(value.toPrecision(4))) : Array.isArray(value) ? `(${value.map(compact).join(", ")})` : value && typeof value === "object" ? Object.entries(value).filter(([, part]) => part !== null).map(([name, part]) => `${name} ${compact(part)}`).join(", ") : String(value));
