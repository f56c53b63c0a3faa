// Program: the YAML text. What is typed is a draft of the page's own until it is applied.

import { button, draw, h } from "./dom.js";
import { on, send } from "./wire.js";

const TAB = "  ";

export function startProgram(host) {
  let data = null, draft = null, applying = false, asked = false;
  const gutter = h("div", { class: "gutter", "aria-hidden": "true" });
  const area = h("textarea", { spellcheck: "false", "aria-label": "Program as YAML", wrap: "off", autocapitalize: "off", readOnly: true });
  const bar = h("div", { class: "row", style: "padding:8px 12px" });
  const list = h("div", { class: "problems" });
  host.append(bar, h("div", { class: "code" }, gutter, area), list);

  const key = () => `studio.draft.${data.session}`;

  area.oninput = () => {
    draft = area.value;
    sessionStorage.setItem(key(), draft);
    lines();
    tools();
  };
  area.onscroll = () => { gutter.scrollTop = area.scrollTop; };
  area.onkeydown = (event) => {
    if (event.key === "Tab" && !event.shiftKey && !area.readOnly) {
      event.preventDefault();
      area.setRangeText(TAB, area.selectionStart, area.selectionEnd, "end");
      area.oninput();
    }
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      apply();
    }
  };

  function validate() {
    asked = true;
    send({ do: "text", text: area.value, apply: false });
  }

  function apply() {
    if (!data) return;
    asked = applying = true;
    send({ do: "text", text: area.value, apply: true });
  }

  function forget() {
    applying = false;
    draft = null;
    if (data && data.session) sessionStorage.removeItem(key());
  }

  function lines() {
    const wrong = new Set(data.problems.map((one) => one.line));
    const count = area.value.split("\n").length;
    // Plain text with marks in bold; 10,000 lines stay one node unless something is wrong.
    if (!wrong.size) gutter.textContent = Array.from({ length: count }, (_, at) => at + 1).join("\n");
    else draw(gutter, Array.from({ length: count }, (_, at) => (wrong.has(at + 1) ? [h("b", {}, `● ${at + 1}`), "\n"] : `${at + 1}\n`)));
    gutter.scrollTop = area.scrollTop;
  }

  function tools() {
    const changed = draft !== null && draft !== data.text;
    area.readOnly = data.readOnly;
    draw(bar,
      button("Validate", validate, { class: "b small" }),
      button("Apply", apply, { class: changed ? "b main small" : "b small", disabled: data.readOnly || !changed, title: "Ctrl+Enter" }),
      changed ? button("Revert", () => { forget(); area.value = data.text; lines(); tools(); }, { class: "b quiet small" }) : null,
      h("span", { class: "muted grow clip hide-narrow", style: "text-align:right", title: data.hash }, data.readOnly ? "read-only" : changed ? "not applied" : data.problems.length ? "" : `${data.hash.slice(0, 8)}`));
    draw(list, data.problems.map((one) => h("button", { type: "button", onclick: () => jump(one.line) }, one.line ? h("b", { class: "num" }, `Line ${one.line}: `) : null, one.path ? h("span", { class: "mono" }, one.path, " ") : null, one.message, one.allowed ? h("span", { class: "muted" }, ` (${one.allowed})`) : null)));
  }

  function jump(line) {
    if (!line) return;
    const rows = area.value.split("\n");
    const from = rows.slice(0, line - 1).reduce((sum, row) => sum + row.length + 1, 0);
    area.focus();
    area.setSelectionRange(from, from + (rows[line - 1] || "").length);
    area.scrollTop = Math.max(0, (line - 6) * 18);
  }

  on("program", (next) => {
    const other = !data || data.session !== next.session;
    if (applying && data && next.hash !== data.hash && !next.problems.length) forget();
    if (next.problems.length) applying = false;
    data = next;
    if (other) {
      draft = sessionStorage.getItem(key());
      area.value = draft !== null ? draft : data.text;
    } else if (draft === null || draft === data.text) {
      forget();
      if (area.value !== data.text) {
        const { scrollTop, selectionStart } = area;
        area.value = data.text;
        area.scrollTop = scrollTop;
        area.setSelectionRange(selectionStart, selectionStart);
      }
    }
    lines();
    tools();
    // What was asked for with Validate or Apply goes to the first mistake.
    if (asked && data.problems.length) jump(data.problems[0].line);
    if (data.problems.length || data.text === area.value) asked = false;
  });
}
