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
  let mine = []; // numbers of one's own, in place of the proposal's

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

  function reset(id) { proposal = id; off = new Set(); values = new Map(); mode = ""; text = ""; answer = ""; mine = []; }

  function card(p, pins) {
    pinned = pins;
    if (p.id !== proposal) reset(p.id);
    return h("div", { class: "card accent stack", key: `proposal-${p.id}`, style: "margin-top:16px", "aria-label": "Proposal", role: "group" },
      h("div", { class: "row wrap", style: "gap:4px 8px" }, h("span", { class: "title", style: "white-space:nowrap;flex:1 0 auto" }, p.gentler ? "A gentler way" : p.hunks.length ? "Proposed repair" : "The planner is stuck"), p.hunks.length && !p.gentler ? h("span", { class: "chip accent clip", title: p.factor }, p.factor) : null),
      p.gentler ? h("p", { class: "muted" }, "The event happens as it is. This would make it happen more gently.") : null,
      h("p", {}, p.rationale),
      p.understood ? h("div", { class: "strip", role: "status" }, h("b", {}, "Understood: "), p.understood) : null,
      p.meant.length ? meant(p) : null,
      p.question ? asked(p) : null,
      p.hunks.length ? null : ways(p),
      p.verified ? h("div", { class: "strip warn" }, "This changes something that was already verified.") : null,
      p.preview && p.hunks.length ? outcome(p.preview) : null,
      p.hunks.map((one) => hunk(p, one)),
      !p.hunks.length ? null : h("div", { class: "row muted", style: "font-size:12px" }, h("span", {}, `Confidence ${p.confidence} %`), h("span", { class: "grow bar" }, h("i", { style: `width:${p.confidence}%` })), p.simulations ? h("span", { class: "num" }, say(p.simulations, "trial")) : null));
  }

  // The bar that decides, which is in sight whatever else is read.
  function bar(p, draft, lead) {
    if (p.id !== proposal) reset(p.id);
    const label = edited() ? "Accept edited" : off.size ? "Accept selected" : "Accept";
    return h("div", { class: sent ? "decide off" : "decide", role: "group", "aria-label": "Decision", "aria-disabled": sent ? "true" : null },
      h("button", { class: "plain row", type: "button", title: "Show all of it, and why", onclick: lead },
        h("span", { class: "title" }, p.gentler ? "A gentler way" : p.hunks.length ? "Proposed repair" : "The planner is stuck"), p.hunks.length ? h("span", { class: "why" }, "Why?") : null,
        p.hunks.length ? h("span", { class: "in-short" }, inShort(lines(p), 2)) : null,
        h("span", { class: "muted" }, brief(p))),
      draft ? h("div", { class: "strip warn" }, "You have edits of your own. Deciding here leaves them behind; undo brings them back.") : null,
      sent ? h("div", { class: "strip", role: "status" }, `${p.gentler && sent === "skip" ? "Kept as it is" : DONE[sent]}; what follows is worked out…`) : null,
      // Keyed, so that a click on one of them never ends on what another becomes.
      h("div", { class: "row", key: "decide" },
        !p.hunks.length ? null : button(label, () => accept(p), { class: "b main wide", disabled: taken(p).length === 0, title: "Accept (A)", "data-act": "accept" }),
        !p.hunks.length ? null : button("Edit", () => set("edit"), { "aria-pressed": String(mode === "edit"), title: "Change the numbers, then accept (E)", "data-act": "edit" }),
        p.gentler ? button("Keep as it is", () => send({ do: "decide", kind: "skip", proposal: p.id }), { title: "Nothing is changed (X)", "data-act": "reject" })
          : !p.hunks.length ? [button("Give a hint", () => set("hint"), { class: "b main wide", "aria-pressed": String(mode === "hint"), title: "Say in your words what should change" }), button("Choose a change", () => set("override"), { "aria-pressed": String(mode === "override"), title: "An action, one of its numbers, and its new value" })]
          : button("Reject", () => set("reject"), { class: "b bad", "aria-pressed": String(mode === "reject"), title: "The planner tries again, knowing why (X)", "data-act": "reject" })),
      p.gentler ? null : h("div", { class: "row wrap ways", key: "otherwise" },
        !p.hunks.length ? null : button("My numbers", () => set("override"), { class: "b quiet", "aria-pressed": String(mode === "override"), title: "Override it: your own numbers in its place" }),
        !p.hunks.length ? null : button("Give a hint", () => set("hint"), { class: "b quiet", "aria-pressed": String(mode === "hint"), title: "Tell the planner something; it tries again, knowing that" }),
        button("Skip it", () => send({ do: "decide", kind: "skip", proposal: p.id }), { class: "b quiet", title: "Go on without this repair" }),
        button("End here", () => send({ do: "decide", kind: "stop", proposal: p.id }), { class: "b quiet", title: "No more rounds: the best one is kept" })),
      form(p));
  }

  // What is taken of it, a line each; what has no row of its own is said by its summary.
  const lines = (p) => taken(p).flatMap((hunk) => !hunk.rows.length ? [{ what: hunk.summary }] : hunk.rows.map((row, at) => {
    const own = values.get(`${hunk.id}/${at}`);
    return own === undefined ? row : { ...row, after: shownAs(row, own) };
  }));

  function brief(p) {
    if (p.preview?.problem) return p.preview.problem;
    if (!p.hunks.length) return "it needs a word from you";
    if (!p.preview) return "not tried out";
    if (edited() || off.size) return "changed by you: not tried out yet";
    return p.preview.passed ? "tried out: the event happens" : `tried out: ${p.preview.ok} of ${p.preview.of} hold`;
  }

  // What a person can do where the planner cannot go on.
  const ways = (p) => h("div", { class: "row wrap", style: "gap:4px", role: "group", "aria-label": "What you can do" },
    button("Draw a mask anew", () => mark(p.about || { kind: "object", name: value("photo")?.objects?.[0]?.name || "" }), { class: "b small", title: "Where a thing is cut out wrong, nothing that follows fits" }),
    button("Demand less", () => document.querySelector(".check .plain")?.click(), { class: "b small", title: "Open what is demanded and change or delete it" }),
    button("Write another sentence", () => dispatchEvent(new CustomEvent("new-sentence")), { class: "b small", title: "The same photo in a new session" }));

  // "later: the start", "earlier: the start": both ways of a number beside its name.
  const byNumber = (meant) => Object.entries(Object.groupBy(meant, (one) => one.say && one.text.split(": ")[1] || one.text));

  // Fields that words could have meant: a click chooses one of them.
  const meant = (p) => h("div", { class: "strip warn stack", role: "group", "aria-label": "What could be meant" },
    h("div", {}, p.understood ? h("b", {}, "Or did you mean:") : [h("b", {}, "Not understood for certain. "), "Did you mean one of these? Nothing was done by itself."]),
    byNumber(p.meant).map(([what, all]) => h("div", { class: "row wrap", style: "gap:4px" }, all.length > 1 ? h("span", { style: "flex:1 1 9em" }, what.replace(/^the /, "")) : null, all.map((one) => button(all.length > 1 ? one.text.slice(0, -what.length - 2) : one.text, () => (!one.say ? mark({ kind: "object", name: value("rounds")?.names?.objects?.[0] || "" }) : send({ do: "decide", kind: "hint", proposal: p.id, reason: one.say })), { class: "b small", "aria-label": one.text })))),
    h("div", { class: "row" },
      button("Something else…", () => set("override"), { class: "b small quiet", title: "Choose whose number, which, and its new value" })));

  // What the planner wants to know; the answer goes to it as a hint.
  function asked(p) {
    const go = () => { if (answer.trim()) send({ do: "decide", kind: "hint", proposal: p.id, reason: answer.trim() }); };
    return h("div", { class: "strip warn stack", key: `question-${p.id}` }, h("div", {}, h("b", {}, "The planner asks: "), p.question),
      p.about ? button(`Mark ${p.about.name.replaceAll("_", " ")} in the photo`, () => mark(p.about), { class: "b small main" }) : null,
      h("textarea", { rows: 2, "aria-label": "Your answer", placeholder: p.about ? "Or answer in words" : "Your answer", oninput: (e) => (answer = e.target.value), onkeydown: (e) => { if (e.key === "Enter" && (e.ctrlKey || e.metaKey)) go(); } }),
      button("Answer", go, { class: "b small" }));
  }

  function outcome(preview) {
    if (edited() || off.size) return h("div", { class: "strip" }, "You changed it: this was not tried out. Accept runs it.");
    if (preview.problem) return h("div", { class: "strip warn" }, preview.problem);
    return h("div", { class: preview.passed ? "strip ok" : "strip" }, preview.passed ? "Tried out: the event happens." : `Tried out: ${preview.ok} of ${preview.of} checks hold.`, h("span", { class: "muted" }, " Its path is drawn in green."));
  }

  function hunk(p, one) {
    const on = !off.has(one.id);
    return h("div", { class: on ? "hunk" : "hunk off", key: one.id },
      h("label", { class: "row top", title: "Untick it to leave this part out" },
        h("input", { type: "checkbox", checked: on, "aria-label": `Take: ${one.summary}`, onchange: () => { if (on) off.add(one.id); else off.delete(one.id); show(); } }),
        h("span", { class: "grow" }, one.summary)),
      one.rows.map((change, at) => changed(one, change, at)));
  }

  function changed(one, change, at) {
    const key = `${one.id}/${at}`;
    const now = values.has(key) ? values.get(key) : change.value;
    return h("div", { class: "change", key },
      h("span", { class: "clip", title: change.what }, change.what),
      h("span", { class: "row", style: "gap:4px" },
        change.op === "set" && (mode !== "edit" || change.fixed) ? [change.value === null && change.before.length > 20 ? null : change.before ? [h("span", { class: "was num" }, change.before), "→"] : null, h("span", { class: "now num" }, values.has(key) ? shownAs(change, now) : change.after), h("span", { class: "faint" }, change.unit)] : change.op === "set" ? h("span", { class: "faint num" }, `was ${change.before} ${change.unit}`) : h("span", { class: "now clip" }, change.after),
        change.op === "set" ? iconButton("pin", "Pin: never change this", () => send({ do: "pin", path: change.path, on: !pinned.includes(change.path) }), { "aria-pressed": String(pinned.includes(change.path)), style: "width:20px;height:20px" }) : null),
      mode === "edit" && change.op === "set" && !change.fixed ? h("div", { class: "nums" }, numbers(now, [], (next) => { values.set(key, next); show(); }, change)) : null);
  }

  // One field per number in a value, however deep it lies.
  function numbers(value, trail, changed, change) {
    const put = (raw) => {
      const number = Number(raw.replace("−", "-").replace(",", "."));
      if (raw.trim() === "" || !Number.isFinite(number)) return false;
      changed(change.scale ? Math.round(number / change.scale) : number);
      return true;
    };
    if (typeof value === "number") {
      const label = [change.what, ...trail].join(" ");
      return h("input", { type: "text", inputmode: "decimal", "data-focus": true, value: String(change.scale ? Number((value * change.scale).toPrecision(4)) : value), "aria-label": label, title: label,
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
    if (mode === "override") return chooser(p);
    return null;
  }

  // An override by clicks: whose number, which number, and what it should be.
  function chooser(p) {
    if (!mine.length) mine = p.hunks.flatMap((one) => one.rows).filter((row) => row.op === "set" && typeof row.value === "number").map((row) => ({ path: row.path, value: row.value }));
    const fields = value("rounds")?.fields || [], groups = [...new Set(fields.map((one) => one.of))];
    const field = (path) => fields.find((one) => one.path === path);
    if (!fields.length) return h("p", { class: "muted" }, "There is no number to change yet: add an action on the timeline.");
    if (!mine.length) mine = [{ path: fields[0].path, value: fields[0].value }];
    const pick = (one, path) => { one.path = path; one.value = field(path).value; show(); };
    return h("div", { class: "stack", role: "group", "aria-label": "Your own change" },
      mine.map((one, at) => {
        const now = field(one.path) || { of: "", what: one.path, value: one.value, unit: "", scale: 1, path: one.path };
        return h("div", { class: "stack", key: `mine${at}`, style: "gap:4px" },
          h("div", { class: "row wrap pair", style: "gap:4px" },
            h("select", { "aria-label": "Of what", value: now.of, "data-focus": at === 0, onchange: (e) => pick(one, fields.find((each) => each.of === e.target.value).path) }, groups.map((of) => h("option", { value: of }, of))),
            h("select", { "aria-label": "Which number", value: one.path, onchange: (e) => pick(one, e.target.value) }, fields.filter((each) => each.of === now.of).map((each) => h("option", { value: each.path }, each.what)))),
          h("div", { class: "row", style: "gap:6px" },
            h("input", { type: "text", inputmode: "decimal", "aria-label": "New value", value: String(Number((one.value * now.scale).toPrecision(5))), oninput: (e) => {
              const number = Number(e.target.value.replace("−", "-").replace(",", "."));
              const good = e.target.value.trim() !== "" && Number.isFinite(number);
              e.target.classList.toggle("wrong", !good);
              if (good) one.value = now.whole ? Math.round(number / now.scale) : number / now.scale;
            } }),
            h("span", { class: "unit faint", style: "white-space:nowrap" }, `${now.unit ? `${now.unit}, ` : ""}now ${Number((now.value * now.scale).toPrecision(4))}`),
            mine.length > 1 ? button("✕", () => { mine.splice(at, 1); show(); }, { class: "b quiet small", "aria-label": "Leave this number out", title: "Leave this number out" }) : null));
      }),
      h("div", { class: "row foot" },
        button("Another number", () => { mine.push({ path: fields[0].path, value: fields[0].value }); show(); }, { class: "b small" }),
        button("Use mine instead", () => send({ do: "decide", kind: "override", proposal: p.id, edits: mine.map((one) => ({ op: "set", path: one.path, value: one.value })) }), { class: "b main wide" })));
  }

  const close = () => { if (!mode) return false; mode = ""; text = ""; show(); return true; };
  return { bar, card, close, forget: () => reset(null) };
}

// "push ball · strength 1.12 → 0.94 m/s; and 2 more": so many changes, and how many more there are.
export const inShort = (rows, most) => [
  rows.slice(0, most).map((one, at) => [at ? "; " : "", one.what, one.before ? [" ", h("span", { class: "was num" }, one.before), " → "] : " ", h("span", { class: "now num" }, `${one.after || ""} ${one.unit || ""}`.trim())]),
  rows.length > most ? `; and ${rows.length - most} more` : ""];

const shownAs = (row, value) => compact(row.scale ? value * row.scale : value);
const compact = (value) => (typeof value === "number" ? String(Number(value.toPrecision(4))) : Array.isArray(value) ? `(${value.map(compact).join(", ")})` : value && typeof value === "object" ? Object.entries(value).filter(([, part]) => part !== null).map(([name, part]) => `${name} ${compact(part)}`).join(", ") : String(value));
