// What the timeline's menus offer: for an action that is there, and for one that is not yet.

import { h } from "./dom.js";
import { edit, send, setField } from "./wire.js";

// `now` gives the timeline's newest { data, head }.
export function startMenus(now) {
  let menu = null;

  const remove = (one) => edit([{ op: "remove", path: `event.actions.${one.id}` }], "removed in the timeline");

  function actionItems(one) {
    if (now().data.readOnly) return [["Select", () => send({ do: "select", kind: "action", name: one.id })]];
    return [
      ["Duplicate", () => duplicate(one)],
      [one.muted ? "Unmute" : "Mute", () => setField(`event.actions.${one.id}.muted`, !one.muted)],
      ["Delete", () => remove(one)],
    ];
  }

  function duplicate(one) {
    const item = { ...one.item, id: fresh(one.id) };
    edit([{ op: "add", path: "event.actions", item }], "duplicated in the timeline");
  }

  function fresh(stem) {
    const known = new Set(now().data.lanes.flatMap((lane) => lane.actions.map((one) => one.id)));
    const root = stem.replace(/_\d+$/, "");
    let count = 2;
    if (!known.has(root)) return root;
    while (known.has(`${root}_${count}`)) count += 1;
    return `${root}_${count}`;
  }

  function addItems(lane, where) {
    const { data, head } = now();
    const known = head && head.selection.kind === "object" && data.lanes.some((one) => one.name === head.selection.name);
    const chosen = lane || (known ? head.selection.name : data.lanes[0].name);
    const at = Math.min(where ?? (head ? head.step : 0), Math.max(0, data.steps - 40));
    const directed = (magnitude) => ({ magnitude, direction: "right" });
    const make = (stem, item) => () => edit([{ op: "add", path: "event.actions", item: { id: fresh(stem), name: chosen, start_step: at, ...item } }], "added in the timeline");
    return [
      [`Push ${chosen}`, make("push", { operator: "ApplyForce", force: { ...directed(2), quantity: "acceleration" }, duration: 20 })],
      [`Set velocity of ${chosen}`, make("velocity", { operator: "SetVelocity", velocity: directed(1) })],
      [`Spin ${chosen}`, make("spin", { operator: "SetAngularVelocity", angular_velocity: [0, 0, 3], duration: 1 })],
      [`Twist ${chosen}`, make("twist", { operator: "ApplyTorque", torque: [0, 0, 0.1], duration: 20 })],
      [`Hold ${chosen}`, make("hold", { operator: "FixObject", duration: 40 })],
      [`Wind on ${chosen}`, make("wind", { operator: "ApplyDisturbance", model: "wind", amplitude: 5, direction: "right", duration: 40 })],
    ];
  }

  function openMenu(event, items) {
    closeMenu();
    menu = h("div", { class: "card stack", role: "menu", style: `position:fixed;z-index:20;gap:1px;padding:4px;left:${Math.min(event.clientX, innerWidth - 210)}px;bottom:${Math.max(8, innerHeight - event.clientY)}px` },
      items.map(([text, act]) => h("button", { class: "b quiet", role: "menuitem", type: "button", style: "text-align:left", onclick: () => { closeMenu(); act(); } }, text)));
    document.body.append(menu);
    menu.querySelector("button").focus();
    setTimeout(() => addEventListener("pointerdown", away), 0);
  }
  const away = (event) => { if (menu && !menu.contains(event.target)) closeMenu(); };
  function closeMenu() {
    removeEventListener("pointerdown", away);
    if (menu) menu.remove();
    menu = null;
  }
  addEventListener("keydown", (event) => { if (event.key === "Escape") closeMenu(); });

  return { actionItems, addItems, closeMenu, openMenu, remove };
}
