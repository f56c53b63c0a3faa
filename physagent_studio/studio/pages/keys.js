// Keyboard: one table of commands feeds the hotkeys, the palette and the help sheet.

import { draw, h } from "./dom.js";
import { on, presenting, scrub, scrubBy, send, value } from "./wire.js";

// What may be done while presenting, by its key.
const LOOKS = new Set(["Space", "ArrowLeft", "ArrowRight", "Shift+ArrowLeft", "Shift+ArrowRight", "Home", "End", "[", "]", "L", "N", "P", "PageDown", "PageUp", "G", "C", "V", "F", "Shift+F", "0", "T", "D", "Shift+P", "Ctrl+K", "?"]);
const looks = (key) => LOOKS.has(key) || /^(Shift\+)?[1-9]$/.test(key);

export function startKeys({ left, right, dialogs, meshFile, scene, theme, presenter, tour, save }) {
  const overlay = h("div", {});
  document.body.append(overlay);
  let sheet = "";

  const head = () => value("playhead") || { frame: 0, frames: 1 };
  const press = (name) => {
    if (name !== "accept") left.show("rounds");
    setTimeout(() => document.querySelector(`[data-act="${name}"]:not(:disabled)`)?.click(), 0);
  };
  const toggle = (what) => {
    const one = (value("scene")?.switches || []).find((item) => item.what === what);
    if (one) send({ do: "show", what, on: !one.on });
  };
  const loop = (part) => {
    const { loop: repeat, loopStart, loopEnd, frame } = head();
    send({ do: "loop", on: part ? true : !repeat, start: part === "start" ? frame : loopStart ?? null, end: part === "end" ? frame : loopEnd ?? null });
  };

  const commands = [
    ["Play or pause", "Space", () => send({ do: "play" })],
    ["One frame back", "ArrowLeft", () => scrubBy(-1)],
    ["One frame on", "ArrowRight", () => scrubBy(1)],
    ["Ten frames back", "Shift+ArrowLeft", () => scrubBy(-10)],
    ["Ten frames on", "Shift+ArrowRight", () => scrubBy(10)],
    ["To the start", "Home", () => scrub(0)],
    ["To the end", "End", () => scrub(Infinity)],
    ["Repeat from here", "[", () => loop("start")],
    ["Repeat up to here", "]", () => loop("end")],
    ["Repeat on or off", "L", () => loop("")],
    ["Forget the repeated part", "", () => send({ do: "loop", on: true })],
    ["Next step, or run my edits", "R", () => send({ do: "step" })],
    ["Run to the end", "Shift+R", () => send({ do: "step", all: true })],
    ["Accept the proposal", "A", () => press("accept")],
    ["Edit the proposal", "E", () => press("edit")],
    ["Reject the proposal", "X", () => press("reject")],
    ["Next round", "N", () => presenter.step(1)],
    ["Previous round", "P", () => presenter.step(-1)],
    ["Next round (presenter's clicker)", "PageDown", () => presenter.step(1)],
    ["Previous round (presenter's clicker)", "PageUp", () => presenter.step(-1)],
    ["Ghosts of other rounds", "G", () => toggle("ghosts")],
    ["Contacts", "C", () => toggle("contacts")],
    ["Forces and velocities", "V", () => toggle("forces")],
    ["Handle to move the selection", "M", () => toggle("gizmo")],
    ["Look at the selection", "F", () => send({ do: "look", view: "selection" })],
    ["Another shape for the selection", "S", () => { const one = head().selection; if (one?.kind === "object") send({ do: "form", name: one.name, kind: null }); }],
    ["Follow the selection", "Shift+F", () => send({ do: "look", view: "follow" })],
    ["The photo's view", "0", () => send({ do: "look", view: "photo" })],
    ["View from the top", "T", () => send({ do: "look", view: "top" })],
    ["Undo", "Ctrl+Z", () => send({ do: "undo" })],
    ["Redo", "Ctrl+Shift+Z", () => send({ do: "undo", forward: true })],
    ["Select nothing", "Escape", () => send({ do: "select", kind: "none" })],
    ["Cancel what is running", "Ctrl+.", () => send({ do: "cancel" })],
    ["Open a case or a session", "O", () => dialogs.open()],
    ["New session from a photo", "Shift+O", () => dialogs.fresh()],
    ...scene.additions.map(([text, add]) => [`Add: ${text.toLowerCase()}`, "", add]),
    ["Add: an object from a mesh file", "", meshFile.open],
    ["Light or dark", "D", () => theme.set(theme.get() === "dark" ? "light" : "dark")],
    ["Presenter mode, on or off", "Shift+P", presenter.toggle],
    ["All commands", "Ctrl+K", () => open("palette")],
    ["Keys", "?", () => open("help")],
    ["Show the rounds", "", () => left.show("rounds")],
    ["Show the plots", "", () => left.show("plots")],
    ["Show the inspector", "", () => right.show("inspector")],
    ["Slow motion: the pace of the clip", "", () => { send({ do: "select", kind: "clip" }); right.show("inspector"); }],
    ["Show the program", "", () => right.show("program")],
    ["Show the photo", "", () => right.show("photo")],
    ["Mark the photo without a mouse", "K", () => { right.show("photo"); const photo = document.querySelector(".photo-stage"); photo.blur(); photo.focus(); }],
    ["Save the clip as a video", "", () => save("video", { do: "video" })],
    ["Save the session as a replay (one HTML file)", "", () => save("replay", { do: "export", kind: "html" })],
    ["Save the scene as a recording (.viser)", "", () => save("recording", { do: "export", kind: "viser" })],
    ["Take the tour", "", tour.start],
    ...Array.from({ length: 9 }, (_, i) => [`View ${i + 1}`, String(i + 1), () => send({ do: "bookmark", slot: i + 1 })]),
    ...Array.from({ length: 9 }, (_, i) => [`Keep as view ${i + 1}`, `Shift+${i + 1}`, () => send({ do: "bookmark", slot: i + 1, keep: true })]),
  ];
  const byKey = new Map(commands.filter(([, key]) => key).map((one) => [one[1], one]));

  function name(event) {
    const digit = /^Digit([1-9])$/.exec(event.code || "");
    const key = event.key === " " ? "Space" : digit && event.shiftKey ? digit[1] : event.key.length === 1 ? event.key.toUpperCase() : event.key;
    const shift = event.shiftKey && (key.length > 1 || /[A-Z0-9]/.test(key));
    return `${event.ctrlKey || event.metaKey ? "Ctrl+" : ""}${shift ? "Shift+" : ""}${key}`;
  }

  const typing = (node) => node && (node.isContentEditable || node.tagName === "TEXTAREA" || node.tagName === "SELECT" || (node.tagName === "INPUT" && node.type !== "checkbox"));

  const presented = (key) => (key === "Escape" ? ["", "", presenter.off] : looks(key) ? byKey.get(key) : null);

  function pressed(event) {
    const key = name(event);
    if (sheet) return;
    if (document.querySelector(".shade") && key !== "Ctrl+K") return;
    const inField = typing(event.target);
    if (inField && !["Ctrl+K", "Ctrl+."].includes(key)) return;
    if (event.target && event.target.tagName === "BUTTON" && (key === "Space" || key === "Enter")) return;
    const command = presenting() ? presented(key) : byKey.get(key);
    if (!command || event.defaultPrevented) return;
    event.preventDefault();
    event.stopPropagation();
    command[2]();
  }
  addEventListener("keydown", pressed);
  // The 3D view is a page of its own; its keys come here too.
  const viewer = document.getElementById("viewer");
  viewer.addEventListener("load", () => viewer.contentWindow.addEventListener("keydown", pressed, true));
  // Nor is it ever :focus-visible: where Tab leads into it, its edge is told to show that.
  let tabbed = false;
  addEventListener("keydown", (event) => { tabbed = event.key === "Tab"; }, true);
  addEventListener("pointerdown", () => { tabbed = false; }, true);
  addEventListener("blur", () => viewer.classList.toggle("focused", tabbed && document.activeElement === viewer));
  addEventListener("focus", () => viewer.classList.remove("focused"));

  // --- palette and help -----------------------------------------------------------------------

  function close() {
    sheet = "";
    draw(overlay);
  }

  function open(which) {
    sheet = which;
    if (which === "help") help();
    else palette("", 0);
  }

  function palette(text, at) {
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    const offered = presenting() ? commands.filter(([, key]) => looks(key)) : commands;
    const found = offered.filter(([label]) => words.every((word) => label.toLowerCase().includes(word)));
    const chosen = Math.max(0, Math.min(found.length - 1, at));
    const go = (one) => { close(); one[2](); };
    draw(overlay, h("div", { class: "shade", onpointerdown: (e) => { if (e.target === e.currentTarget) close(); } },
      h("div", { class: "dialog palette", role: "dialog", "aria-label": "All commands" },
        h("input", { type: "text", placeholder: "What do you want to do?", "aria-label": "Command", value: text,
          oninput: (e) => palette(e.target.value, 0),
          onkeydown: (e) => {
            e.stopPropagation();
            if (e.key === "Escape") close();
            else if (e.key === "ArrowDown") palette(text, chosen + 1);
            else if (e.key === "ArrowUp") palette(text, chosen - 1);
            else if (e.key === "Enter" && found[chosen]) go(found[chosen]);
            else return;
            e.preventDefault();
          } }),
        h("ul", { role: "listbox" }, found.map((one, i) => h("li", { role: "option", class: i === chosen ? "on" : "", "aria-selected": String(i === chosen), onclick: () => go(one) }, h("span", { class: "grow" }, one[0]), one[1] ? h("kbd", {}, pretty(one[1])) : null))))));
    overlay.querySelector("input").focus();
    overlay.querySelector("li.on")?.scrollIntoView({ block: "nearest" });
  }

  function help() {
    draw(overlay, h("div", { class: "shade", onpointerdown: close },
      h("div", { class: "dialog", role: "dialog", "aria-label": "Keys" },
        h("header", {}, h("div", { class: "title grow" }, "Keys"), h("button", { class: "b quiet", type: "button", onclick: close }, "Close")),
        h("div", { class: "body", style: "columns:2 260px;column-gap:28px" }, commands.filter(([, key]) => key && !/^(Shift\+)?[1-9]$/.test(key)).map(([label, key]) => h("div", { class: "row", style: "break-inside:avoid;padding:3px 0" }, h("span", { class: "grow" }, label), h("kbd", {}, pretty(key)))), h("div", { class: "row", style: "padding:3px 0" }, h("span", { class: "grow" }, "Go to a kept view; with Shift keep it"), h("kbd", {}, "1 … 9")),
          h("div", { class: "row", style: "padding:3px 0" }, h("span", { class: "grow" }, "On a bar: move, with Ctrl resize"), h("kbd", {}, "← →")),
          h("div", { class: "row", style: "padding:3px 0" }, h("span", { class: "grow" }, "On the photo: move the cross, with Shift further"), h("kbd", {}, "← ↑ ↓ →")),
          h("div", { class: "row", style: "padding:3px 0" }, h("span", { class: "grow" }, "On the photo: what a click does there, with Alt outside"), h("kbd", {}, "Space"))))));
    overlay.querySelector("button").focus();
  }
  addEventListener("keydown", (event) => { if (event.key === "Escape" && sheet) { event.stopPropagation(); close(); } }, true);
  return { open };
}

const pretty = (key) => key.replace("ArrowLeft", "←").replace("ArrowRight", "→");
