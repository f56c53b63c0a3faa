// The photo's stage: the picture with overlays, zoom, pan, and pixels under the pointer.

import { h } from "./dom.js";

export function startStage(host, { onTool }) {
  const picture = h("image", { x: 0, y: 0 });
  const layers = Object.fromEntries(["outlines", "marks", "live"].map((name) => [name, h("g", { class: `ph-${name}` })]));
  const svg = h("svg", { preserveAspectRatio: "xMidYMid meet" }, picture, layers.outlines, layers.marks, layers.live);
  const corner = h("div", { class: "photo-corner" });
  const stage = h("div", { class: "photo-stage", tabindex: "0", role: "application", "data-tool": "look" }, svg, corner);
  const view = { x: 0, y: 0, w: 1, h: 1, size: [1, 1] };
  let pan = null;
  let held = false; // whether the pointer went down on the picture
  const scaled = new Set();

  function apply() {
    svg.setAttribute("viewBox", `${view.x} ${view.y} ${view.w} ${view.h}`);
    for (const listener of scaled) listener();
  }

  function fit() {
    [view.x, view.y] = [0, 0];
    [view.w, view.h] = view.size;
    apply();
  }

  function show(address, size) {
    if (picture.getAttribute("href") === address) return;
    picture.setAttribute("href", address);
    picture.setAttribute("width", size[0]);
    picture.setAttribute("height", size[1]);
    view.size = size;
    svg.style.aspectRatio = `${size[0]} / ${size[1]}`;
    fit();
  }

  // Photo pixels per pixel of the screen, so that dots keep their size.
  function unit() {
    const box = svg.getBoundingClientRect();
    return box.width ? Math.max(view.w / box.width, view.h / box.height) : 1;
  }

  function at(event) {
    const matrix = svg.getScreenCTM();
    if (!matrix) return [0, 0];
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    return [point.x, point.y];
  }

  // Where a pixel of the photo is in the window.
  function client([x, y]) {
    const matrix = svg.getScreenCTM();
    if (!matrix) return [0, 0];
    const point = new DOMPoint(x, y).matrixTransform(matrix);
    return [point.x, point.y];
  }

  const inside = ([x, y]) => [Math.max(0, Math.min(view.size[0] - 0.01, x)), Math.max(0, Math.min(view.size[1] - 0.01, y))];

  function zoom(factor, [x, y]) {
    const width = Math.max(24, Math.min(view.size[0], view.w * factor));
    const real = width / view.w;
    view.x = x - (x - view.x) * real;
    view.y = y - (y - view.y) * real;
    view.w = width;
    view.h *= real;
    hold();
    apply();
  }

  function hold() {
    view.x = Math.max(0, Math.min(view.size[0] - view.w, view.x));
    view.y = Math.max(0, Math.min(view.size[1] - view.h, view.y));
  }

  // Moves what is on view just so far that a place is inside it.
  function reveal([x, y]) {
    const rim = 16 * unit();
    view.x = Math.max(x + rim - view.w, Math.min(x - rim, view.x));
    view.y = Math.max(y + rim - view.h, Math.min(y - rim, view.y));
    hold();
    apply();
  }

  const middle = () => [view.x + view.w / 2, view.y + view.h / 2];

  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.0035), at(event));
  }, { passive: false });
  stage.addEventListener("contextmenu", (event) => event.preventDefault());
  stage.addEventListener("pointerdown", (event) => {
    if (event.target.closest(".photo-corner")) return;
    held = true;
    stage.focus({ preventScroll: true });
    stage.setPointerCapture(event.pointerId);
    if (event.button === 1 || stage.dataset.tool === "look") {
      pan = { from: [event.clientX, event.clientY], x: view.x, y: view.y, moved: false };
      if (event.button === 1) event.preventDefault();
    } else onTool("down", at(event), event);
  });
  stage.addEventListener("pointermove", (event) => {
    if (!pan) return onTool("move", at(event), event);
    const per = unit();
    const [dx, dy] = [event.clientX - pan.from[0], event.clientY - pan.from[1]];
    if (!pan.moved && Math.hypot(dx, dy) < 4) return;
    pan.moved = true;
    stage.classList.add("panning");
    view.x = pan.x - dx * per;
    view.y = pan.y - dy * per;
    hold();
    apply();
  });
  const letGo = () => {
    [pan, held] = [null, false];
    stage.classList.remove("panning");
  };
  stage.addEventListener("pointercancel", (event) => { letGo(); onTool("cancel", at(event), event); });
  stage.addEventListener("pointerup", (event) => {
    if (!held) return;
    const still = pan && !pan.moved;
    const panned = pan;
    letGo();
    if (!panned) onTool("up", at(event), event);
    else if (still && event.button === 0) onTool("pick", at(event), event);
  });
  stage.addEventListener("pointerleave", (event) => { if (!pan) onTool("leave", at(event), event); });
  stage.addEventListener("dblclick", (event) => { if (!event.target.closest(".photo-corner")) onTool("double", at(event), event); });

  const press = (label, text, act) => h("button", { type: "button", title: label, "aria-label": label, onclick: act }, text);
  const large = (on) => {
    stage.classList.toggle("large", on ?? !stage.classList.contains("large"));
    apply();
  };
  corner.append(
    press("Zoom in", "+", () => zoom(0.7, middle())),
    press("Zoom out", "−", () => zoom(1 / 0.7, middle())),
    press("Whole photo", "▢", fit),
    press("Large photo", "⤢", () => large()),
  );
  new ResizeObserver(() => apply()).observe(stage);
  host.append(stage);
  return { stage, layers, show, unit, client, inside, reveal, held: () => held, large, scaled: (listener) => scaled.add(listener) };
}
