// Shelf: examples and sessions to open, to rename, to copy and to delete.

import { button, h, iconButton, say } from "./dom.js";
import { send, value } from "./wire.js";

const OUTCOME = { realised: ["ok", "happens"], budget: ["warn", "rounds used up"], stopped: ["", "stopped"], stuck: ["warn", "stuck"], cancelled: ["warn", "cancelled"], interrupted: ["warn", "interrupted"] };
const MANY = 8; // more sessions than these get a field to find one
const FIRST = 6; // sessions shown at first, so that the examples are not far

export function makeShelf(show, { close, fresh }) {
  let acting = ""; // key of the session that is renamed or about to be deleted
  let mode = ""; // "", rename, delete
  let wanted = "";
  let shown = FIRST;

  const reset = () => { acting = ""; mode = ""; wanted = ""; shown = FIRST; };
  const open = (key, event) => { send({ do: "open", key, event: event || "" }); close(); };
  const focus = (which) => setTimeout(() => document.querySelector(`.dialog ${which}`)?.focus(), 0);
  const act = (next, key) => { mode = next; acting = key; show(); focus(next ? "[data-focus]" : `[data-key="${key}"]`); };

  const face = (one) => h("span", { class: "face" }, one.face ? h("img", { loading: "lazy", decoding: "async", alt: "", width: 56, height: 36, src: one.face, onerror: (e) => e.target.remove() }) : null);

  function example(one, event) {
    return h("button", { class: "entry", type: "button", key: `${one.key}/${event.name}`, onclick: () => open(one.key, event.name) }, face(one),
      h("span", { class: "grow" }, h("b", {}, event.name.replaceAll("_", " ")), h("div", { class: "muted" }, `“${event.prompt}”`)), h("span", { class: "chip" }, one.name));
  }

  function session(one) {
    if (acting === one.key && mode) return h("div", { class: "entry", key: `act-${one.key}` }, face(one), mode === "rename" ? renaming(one) : deleting(one));
    const [tone, word] = one.inDoubt ? ["warn", "happens, as far as it is tested"] : OUTCOME[one.outcome] || ["", one.outcome];
    return h("div", { class: "entry-row", key: `row-${one.key}` },
      h("button", { class: "entry", type: "button", key: one.key, onclick: () => open(one.key) }, face(one),
        h("span", { class: "grow", style: "min-width:0" }, h("div", {}, h("b", {}, one.title)), h("div", { class: "muted" }, one.prompt || "No sentence yet")),
        h("span", { class: "muted num hide-narrow", title: one.modified }, say(one.rounds, "round")),
        h("span", { class: `chip ${tone}`, title: one.inDoubt ? `Happens ${one.inDoubt}` : null }, one.open ? "on view" : word)),
      h("span", { class: "row", style: "gap:0" },
        iconButton("pen", `Rename “${one.title}”`, () => act("rename", one.key)),
        iconButton("copy", `Duplicate “${one.title}”`, () => send({ do: "duplicate_session", key: one.key })),
        iconButton("bin", one.open ? "The session on view cannot be deleted; open another one first" : `Delete “${one.title}”`, () => act("delete", one.key), { disabled: one.open })));
  }

  function renaming(one) {
    const go = (node) => { if (node.value.trim()) send({ do: "rename_session", key: one.key, title: node.value.trim() }); act("", one.key); };
    return [h("input", { type: "text", class: "grow", value: one.title, maxlength: 200, "aria-label": "Title of the session", "data-focus": true, onkeydown: (e) => {
      if (e.key !== "Enter" && e.key !== "Escape") return;
      e.stopPropagation();
      e.preventDefault();
      if (e.key === "Enter") go(e.target);
      else act("", one.key);
    } }),
    button("Rename", (e) => go(e.target.closest(".entry").querySelector("input")), { class: "b main small" }),
    button("Cancel", () => act("", one.key), { class: "b small" })];
  }

  function deleting(one) {
    return [h("span", { class: "grow" }, "Delete ", h("b", {}, one.title), ` and its ${say(one.rounds, "round")}?`),
      button("Delete", () => { send({ do: "delete_session", key: one.key }); act("", one.key); }, { class: "b bad small", "data-focus": true }),
      button("Keep", () => act("", one.key), { class: "b small" })];
  }

  function page() {
    const library = value("library") || { cases: [], sessions: [] };
    const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
    const found = library.sessions.filter((one) => words.every((word) => `${one.title} ${one.prompt}`.toLowerCase().includes(word)));
    const most = words.length ? Math.max(shown, 40) : shown;
    return [
      h("div", { class: "row wrap" }, button("New from a photo…", fresh, { class: "b main" }), button("Empty scene", () => { send({ do: "bare" }); close(); })),
      library.sessions.length ? h("div", { class: "head" }, "Your sessions", h("span", { class: "push num" }, library.sessions.length)) : null,
      library.sessions.length > MANY ? h("input", { type: "text", placeholder: "Find a session", "aria-label": "Find a session", value: wanted, style: "margin-bottom:8px", oninput: (e) => { wanted = e.target.value; show(); } }) : null,
      h("div", { class: "stack", role: "list", "aria-label": "Sessions" }, found.slice(0, most).map(session)),
      found.length > most ? h("p", { style: "padding:8px 0" }, button(`Show ${found.length - most} more`, () => { shown = most + 100; show(); }, { class: "b small" })) : null,
      words.length && !found.length ? h("p", { class: "muted" }, "No session has these words.") : null,
      library.cases.length ? h("div", { class: "head" }, "Examples") : null,
      h("div", { class: "stack" }, library.cases.flatMap((one) => one.events.map((event) => example(one, event)))),
    ];
  }

  return { page, reset };
}
