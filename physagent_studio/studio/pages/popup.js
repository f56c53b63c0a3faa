// Popup: a short menu at a button; a click elsewhere or Escape closes it.

import { h } from "./dom.js";

let menu = null;
let from = null;

export function openPopup(anchor, items, label) {
  const again = menu && from === anchor;
  closePopup();
  if (again) return;
  const box = anchor.getBoundingClientRect();
  from = anchor;
  menu = h("div", { class: "card popup", role: "menu", "aria-label": label, style: `top:${box.bottom + 4}px;right:${Math.max(8, innerWidth - box.right)}px` },
    items.map(([text, key, act, title]) => h("button", { class: "b quiet row", role: "menuitem", type: "button", title, onclick: () => { closePopup(); act(); } }, h("span", { class: "grow" }, text), key ? h("kbd", {}, key) : null)));
  document.body.append(menu);
  menu.querySelector("button").focus();
  setTimeout(() => addEventListener("pointerdown", away), 0);
}

export function closePopup() {
  removeEventListener("pointerdown", away);
  menu?.remove();
  [menu, from] = [null, null];
}

const away = (event) => { if (menu && !menu.contains(event.target) && !from?.contains(event.target)) closePopup(); };

addEventListener("keydown", (event) => {
  if (!menu) return;
  const all = [...menu.querySelectorAll("button")], at = all.indexOf(document.activeElement);
  const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  if (event.key !== "Escape" && !by) return;
  event.preventDefault();
  event.stopPropagation();
  if (by) all[(at + by + all.length) % all.length].focus();
  else { from?.focus?.(); closePopup(); }
}, true);
