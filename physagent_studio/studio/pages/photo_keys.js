// The photo without a pointer: a cross that arrow keys move, and what a click does at the cross.

import { h } from "./dom.js";

const STEP = 4; // pixels of the screen
const FAR = 24; // the same with Shift
const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const HELD = ["brush", "horizon"]; // tools that draw from one key press to the next
export const HOW = "Arrow keys move a cross (Shift: further), Space or Enter marks there, Escape leaves.";

export function makePhotoKeys({ stage, tools, data, changed }) {
  const { state } = tools;
  const told = h("span", { class: "unseen", role: "status" });
  stage.stage.append(told);
  let cross = null; // where it is, in pixels of the photo
  let on = false; // whether the keys are the photo's
  let held = false; // whether a tool draws on

  const event = (more) => {
    const [clientX, clientY] = stage.client(cross);
    return { button: 0, detail: 1, altKey: false, shiftKey: false, target: document.elementFromPoint(clientX, clientY) || stage.stage, clientX, clientY, ...more };
  };

  // Focus that did not come with the pointer hands the keys over; without it they are the page's.
  stage.stage.addEventListener("focus", () => {
    if (stage.held()) return;
    on = true;
    cross ||= data() ? [data().size[0] / 2, data().size[1] / 2] : null;
    tell();
  });
  const leave = () => {
    if (held) tools.on("cancel", cross, event());
    [on, held] = [false, false];
    changed();
  };
  stage.stage.addEventListener("blur", leave);
  stage.stage.addEventListener("pointerdown", leave);

  function move([dx, dy], step) {
    const by = Math.max(1, step * stage.unit());
    cross = stage.inside([cross[0] + dx * by, cross[1] + dy * by]);
    stage.reveal(cross);
    tools.on("move", cross, event());
    tell();
  }

  function place(more) {
    if (state.tool === "look" || data().readOnly) tools.on("pick", cross, event(more));
    else if (HELD.includes(state.tool)) {
      tools.on(held ? "up" : "down", cross, event(more));
      held = !held;
    } else for (const phase of ["down", "up"]) tools.on(phase, cross, event(more));
    tell();
  }

  // For those who hear the page: where the cross is, and what it is on.
  function tell() {
    if (!cross) return;
    const name = event().target.closest?.("[data-name]")?.dataset.name;
    told.textContent = `${Math.round(cross[0])} across, ${Math.round(cross[1])} down${name ? `, ${name.replaceAll("_", " ")}` : ""}`;
    changed();
  }

  // Whether a key was the cross's.
  function pressed({ key, shiftKey, altKey, ctrlKey, metaKey }) {
    if (!on || !cross || ctrlKey || metaKey) return false;
    if (WAYS[key]) move(WAYS[key], shiftKey ? FAR : STEP);
    else if (key === " " || (key === "Enter" && (held || !tools.busy()))) place({ altKey, shiftKey });
    else if (key === "Escape" && held) {
      held = false;
      tools.on("cancel", cross, event());
    } else if (key === "Escape" && !tools.busy()) stage.stage.blur();
    else return false;
    return true;
  }

  function draw(unit) {
    if (!on || !cross) return null;
    const [x, y] = cross, near = 3 * unit, far = 13 * unit;
    const d = `M${x - far} ${y}H${x - near}M${x + near} ${y}H${x + far}M${x} ${y - far}V${y - near}M${x} ${y + near}V${y + far}`;
    return h("g", { class: held ? "ph-cross on" : "ph-cross" }, h("path", { class: "ph-cross-case", d }), h("path", { d }));
  }

  return { pressed, draw };
}
