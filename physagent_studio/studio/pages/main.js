// The page: where panels sit, tabs, dividers, theme, and what starts when.

import { draw, h } from "./dom.js";
import { startDialogs } from "./dialogs.js";
import { viewerQuery } from "./drawing.js";
import { startInspector } from "./inspector.js";
import { startKeys } from "./keys.js";
import { startMeshFile } from "./mesh_file.js";
import { startNotices } from "./notices.js";
import { startPhoto } from "./photo.js";
import { startPlots } from "./plots.js";
import { startProgram } from "./program.js";
import { startPresenter } from "./presenter.js";
import { startRounds } from "./rounds.js";
import { startRun } from "./run.js";
import { startScene } from "./scene.js";
import { startTimeline } from "./timeline.js";
import { startTour } from "./tour.js";
import { copyLink, startAutoplay, startLinks } from "./moments.js";
import { openPicture } from "./picture.js";
import { connect, on, viewerToken } from "./wire.js";

const keep = (name, data) => localStorage.setItem(`studio.${name}`, JSON.stringify(data));
const kept = (name, otherwise) => {
  try {
    return JSON.parse(localStorage.getItem(`studio.${name}`)) ?? otherwise;
  } catch {
    return otherwise;
  }
};

const autoplay = () => kept("autoplay", true);

function tabs(host, name, pages) {
  const bar = h("div", { class: "tabs", role: "tablist" });
  const bodies = {};
  host.append(bar);
  for (const [key, text, flush] of pages) {
    bodies[key] = h("div", { class: flush ? "page flush" : "page", role: "tabpanel", id: `page-${key}`, "aria-label": text });
    host.append(bodies[key]);
  }
  const show = (chosen) => {
    keep(`tab.${name}`, chosen);
    draw(bar, pages.map(([key, text]) =>
      h("button", { key, type: "button", role: "tab", "aria-selected": String(key === chosen), onclick: () => show(key) }, text)));
    for (const [key, body] of Object.entries(bodies)) body.hidden = key !== chosen;
    window.dispatchEvent(new Event("resize"));
  };
  const first = kept(`tab.${name}`, pages[0][0]);
  show(bodies[first] ? first : pages[0][0]);
  return { bodies, show };
}

function divider(id, property, measure, low, high) {
  const grip = document.getElementById(id);
  const set = (pixels) => {
    const size = Math.round(Math.max(low, Math.min(high(), pixels)));
    document.documentElement.style.setProperty(property, `${size}px`);
    return size;
  };
  const saved = kept(property, null);
  if (saved) set(saved);
  grip.tabIndex = 0;
  grip.setAttribute("role", "separator");
  grip.setAttribute("aria-label", "Divider: arrow keys move it");
  // Arrow keys move it as the pointer does, from where it is.
  grip.onkeydown = (event) => {
    const [dx, dy] = { ArrowLeft: [-16, 0], ArrowRight: [16, 0], ArrowUp: [0, -16], ArrowDown: [0, 16] }[event.key] || [0, 0];
    const box = grip.getBoundingClientRect(), wide = box.width > box.height;
    if (wide ? !dy : !dx) return;
    event.preventDefault();
    event.stopPropagation();
    keep(property, set(measure({ clientX: box.x + box.width / 2 + dx, clientY: box.y + box.height / 2 + dy })));
    window.dispatchEvent(new Event("resize"));
  };
  grip.onpointerdown = (event) => {
    grip.setPointerCapture(event.pointerId);
    grip.classList.add("on");
    document.getElementById("viewer").style.pointerEvents = "none";
    grip.onpointermove = (move) => keep(property, set(measure(move)));
  };
  grip.onpointerup = grip.onpointercancel = () => {
    grip.onpointermove = null;
    grip.classList.remove("on");
    document.getElementById("viewer").style.pointerEvents = "";
    window.dispatchEvent(new Event("resize"));
  };
  grip.ondblclick = () => {
    localStorage.removeItem(`studio.${property}`);
    document.documentElement.style.removeProperty(property);
  };
}

export const theme = {
  get: () => kept("theme", matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"),
  set(name) {
    keep("theme", name);
    theme.show();
  },
  show() {
    const name = theme.get();
    document.documentElement.dataset.theme = name;
    const viewer = document.getElementById("viewer");
    const address = `viewer/${viewerToken}/${viewerQuery(name === "dark")}`;
    if (viewer.getAttribute("src") === address) return;
    viewer.src = address;
    dispatchEvent(new Event("viewer"));
  },
};

function start() {
  theme.show();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", theme.show);
  addEventListener("drawing", theme.show);
  divider("split-left", "--left", (e) => e.clientX, 200, () => innerWidth * 0.4);
  divider("split-right", "--right", (e) => innerWidth - e.clientX, 200, () => innerWidth * 0.45);
  divider("split-bottom", "--bottom", (e) => innerHeight - e.clientY, 90, () => innerHeight * 0.6);
  const left = tabs(document.getElementById("left"), "left", [["rounds", "Rounds"], ["plots", "Plots"]]);
  const right = tabs(document.getElementById("details"), "right", [
    ["inspector", "Inspector"], ["program", "Program", true], ["photo", "Photo"], ["scene", "Scene"],
  ]);
  startNotices(document.getElementById("notices"));
  const dialogs = startDialogs(document.getElementById("overlay"));
  const more = () => [
    [theme.get() === "dark" ? "Light" : "Dark", "D", () => theme.set(theme.get() === "dark" ? "light" : "dark")],
    ["Present", "Shift+P", () => presenter.toggle(), "Large type and nothing to edit, for showing it to others"],
    [autoplay() ? "Do not play new rounds" : "Play each new round once", "", () => keep("autoplay", !autoplay())],
    ["Copy a link to this moment", "", () => copyLink(), "It opens this session at this round and frame"],
    ["Picture of the scene…", "", () => openPicture(), "A PNG at the size that you choose"],
    ["Tour", "", () => tour.start()],
    ["All commands", "Ctrl+K", () => keys.open("palette")],
    ["Keys", "?", () => keys.open("help")],
  ];
  const run = startRun(document.getElementById("run"), dialogs, more);
  const dock = document.getElementById("left").appendChild(h("div", { id: "decision", hidden: true }));
  startRounds(left.bodies.rounds, dock, { showRounds: () => left.show("rounds"), showPlots: () => left.show("plots"), showPhoto: () => right.show("photo") });
  startPlots(left.bodies.plots);
  startInspector(right.bodies.inspector);
  startProgram(right.bodies.program);
  startPhoto(right.bodies.photo);
  addEventListener("new-sentence", () => dialogs.fresh());
  const meshFile = startMeshFile(document.body.appendChild(h("div", {})));
  const scene = startScene(right.bodies.scene, document.getElementById("viewbar"), document.getElementById("banner"), meshFile, () => right.show("inspector"));
  startTimeline(document.getElementById("timeline"), () => right.show("inspector"));
  const presenter = startPresenter(left);
  const tour = startTour(() => !document.querySelector(".shade"));
  const keys = startKeys({ left, right, dialogs, meshFile, scene, theme, presenter, tour, save: run.save });
  // What is selected shows its numbers, whichever tab is open; in the photo a thing is worked on.
  on("selection", ({ kind }) => { if (["action", "statement", "clip"].includes(kind)) right.show("inspector"); });
  startAutoplay(autoplay);
  startLinks();
  connect();
}

start();
