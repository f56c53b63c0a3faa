// Notices: passing ones from the studio, lasting ones from the workbench, and a lost line.

import { draw, h } from "./dom.js";
import { on, send } from "./wire.js";

const STAY = { info: 5000, warning: 9000, error: 14000 };
const MOST = 4; // lasting ones on view; what is behind them comes up as they are put away
const OFFERED = 45000; // something can be done about it, so it waits longer

export function startNotices(host) {
  let passing = [];
  let lasting = [];
  let line = true;
  let count = 0;

  // The same said again is one notice that counts; putting it away puts all of them away.
  function held() {
    const groups = new Map();
    for (const one of lasting) groups.set(`${one.level} ${one.text}`, [...(groups.get(`${one.level} ${one.text}`) || []), one]);
    const all = [...groups.values()].map((same) => ({ ...same[0], times: same.length, close: () => { for (const one of same) send({ do: "dismiss", id: one.id }); } }));
    return all.slice(-MOST);
  }

  const show = () =>
    draw(host,
      line ? null : h("div", { class: "notice warning", key: "line" }, h("div", { class: "grow" }, "The studio does not answer. This page goes on as soon as it does.")),
      [...held(), ...passing].map((one) =>
        h("div", { class: `notice ${one.level}`, key: one.key || `w${one.id}`, role: one.level === "error" ? "alert" : "status" },
          h("div", { class: "grow pre" }, one.text.charAt(0).toUpperCase() + one.text.slice(1), one.times > 1 ? h("span", { class: "muted" }, ` (${one.times} times)`) : null),
          one.offer ? h("button", { class: "b small", type: "button", onclick: () => { send(one.do); one.close(); } }, one.offer) : null,
          h("button", { class: "b quiet small", type: "button", "aria-label": "Dismiss", onclick: one.close }, "✕"))));

  const drop = (key) => {
    passing = passing.filter((one) => one.key !== key);
    show();
  };
  addEventListener("told", (event) => say({ level: "info", text: event.detail }));
  on("say", say);
  function say(one) {
    count += 1;
    const key = `p${count}`;
    if (passing.some((other) => other.text === one.text)) return;
    passing = [...passing.slice(-3), { ...one, key, close: () => drop(key) }];
    setTimeout(() => drop(key), one.offer ? OFFERED : STAY[one.level] || 5000);
    show();
  }
  const timed = new Set();
  on("notices", (all) => {
    lasting = all;
    for (const one of all) {
      if (one.level !== "info" || timed.has(one.id)) continue;
      timed.add(one.id);
      setTimeout(() => send({ do: "dismiss", id: one.id }), STAY.info);
    }
    show();
  });
  on("line", (up) => {
    line = up;
    show();
  });
}
