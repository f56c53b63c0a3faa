// Dialogs: open a case or a session, and a new session from a photo.

import { button, draw, dropping, h, keepInside, say } from "./dom.js";
import { makeShelf } from "./shelf.js";
import { on, send, value } from "./wire.js";

const MAX_PHOTO = 16 * 2 ** 20, LONGEST = 4000;
const COLORS = ["#2f6fed", "#d9482b", "#17885a", "#a15cd6", "#d97706", "#0e9384", "#c0398c", "#667085"];

export function startDialogs(host) {
  let kind = "";
  let photo = null; // { file, url, data, width, height }
  let things = [{ name: "object", clicks: [] }];
  let at = 0;
  let prompt = "";
  let problem = "";

  let sent = null; // a photo on its way: in which session it was sent, and the newest error then
  let from = null; // what had the focus before the dialog

  const close = () => { kind = ""; draw(host); from?.focus?.({ preventScroll: true }); from = null; };
  const shell = (title, body, foot) => draw(host, h("div", { class: "shade", onpointerdown: (e) => { if (e.target === e.currentTarget) close(); }, onkeydown: (e) => { if (e.key === "Escape") close(); else keepInside(e); } },
    h("div", { class: "dialog", role: "dialog", "aria-modal": "true", "aria-label": title }, h("header", {}, h("div", { class: "title grow" }, title), button("Close", close, { class: "b quiet" })), h("div", { class: "body" }, body), foot ? h("footer", {}, foot) : null)));

  const shelf = makeShelf(() => shell("Open", shelf.page()), {
    close,
    fresh: () => { kind = "new"; show(); host.querySelector("input,textarea")?.focus(); },
  });

  function show() {
    if (kind === "open") shell("Open", shelf.page());
    if (kind === "new") fresh();
  }

  // --- new ------------------------------------------------------------------------------------

  async function take(file) {
    problem = "";
    if (!file) return;
    if (file.size > MAX_PHOTO) { problem = `The photo has ${(file.size / 2 ** 20).toFixed(1)} MB; at most 16 are allowed.`; return show(); }
    const url = URL.createObjectURL(file);
    const image = new Image();
    image.src = url;
    try { await image.decode(); } catch { problem = "This file is no picture that can be shown."; return show(); }
    const bytes = new Uint8Array(await file.arrayBuffer());
    let text = "";
    for (let from = 0; from < bytes.length; from += 32768) text += String.fromCharCode(...bytes.subarray(from, from + 32768));
    photo = { url, data: btoa(text), width: image.naturalWidth, height: image.naturalHeight };
    things = [{ name: "object", clicks: [] }];
    at = 0;
    show();
    // The field that had the focus is gone.
    host.querySelector("textarea")?.focus({ preventScroll: true });
  }

  function click(event) {
    const box = event.currentTarget.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * photo.width, y = ((event.clientY - box.top) / box.height) * photo.height;
    things[at].clicks.push({ x: Math.round(x * 10) / 10, y: Math.round(y * 10) / 10, label: event.shiftKey || event.button === 2 ? 0 : 1 });
    show();
  }

  // What keeps it from starting, in words; "" where nothing does.
  function lacks() {
    const wrong = things.find((one) => one.clicks.length && !/^[A-Za-z0-9_][A-Za-z0-9_-]{0,63}$/.test(tidy(one.name)));
    if (wrong) return `“${wrong.name}” cannot be a name: letters from a to z, digits, - and _, at most 64.`;
    if (prompt.length > LONGEST) return `The sentence has ${prompt.length} characters; at most ${LONGEST} are allowed.`;
    if (!prompt.trim()) return "Say what shall happen, in a sentence.";
    const unnamed = things.findIndex((one) => one.clicks.length && /^object(_\d+)?$/.test(tidy(one.name)) && !prompt.toLowerCase().includes(one.name.trim().replaceAll("_", " ")));
    return unnamed < 0 ? "" : `Call thing ${unnamed + 1} what the sentence calls it, so that it is known which one is meant.`;
  }
  const ready = () => photo && !lacks();
  const tidy = (name) => name.trim().replace(/\s+/g, "_");

  // A second click comes before the dialog is gone.
  function begin() {
    if (kind !== "new" || !ready()) return;
    const objects = things.filter((one) => one.clicks.length).map((one) => [tidy(one.name), one.clicks]);
    if (!send({ do: "new", photo: photo.data, prompt: prompt.trim(), objects })) return;
    sent = { session: value("run")?.session, error: newest(value("notices") || []) };
    problem = "";
    close();
  }

  const newest = (notices) => Math.max(0, ...notices.filter((one) => one.level === "error").map((one) => one.id));

  // What could not be begun comes back as it was, with the reason.
  function refused(text) {
    sent = null;
    problem = text.charAt(0).toUpperCase() + text.slice(1);
    enter("new", "textarea");
  }

  function fresh() {
    shell("New session from a photo", [
      problem ? h("div", { class: "strip bad", style: "margin-bottom:10px" }, problem) : null,
      !photo ? h("label", { class: "entry drop", ...dropping(take) },
        h("span", { class: "muted" }, h("b", {}, "Choose a photo"), " or drop one here · PNG, JPEG or WebP"), h("input", { type: "file", accept: "image/png,image/jpeg,image/webp", "aria-label": "Photo", onchange: (e) => take(e.target.files[0]) })) : [
        h("p", { class: "muted", style: "margin-bottom:8px" }, "Click on a thing that takes part and call it what the sentence calls it, then add the next with “Another thing”. Right-click or Shift+click marks what does not belong to it. Without any click, what the sentence names is looked for."),
        h("div", { class: "photo", style: `cursor:crosshair;margin-inline:auto;width:min(100%, ${(36 * photo.width / photo.height).toFixed(2)}vh)`, "data-photo": true, onclick: click, oncontextmenu: (e) => { e.preventDefault(); click(e); } },
          h("img", { src: photo.url, alt: "Your photo", draggable: "false" }),
          h("svg", { viewBox: `0 0 ${photo.width} ${photo.height}`, preserveAspectRatio: "none", "pointer-events": "none" }, things.flatMap((one, i) => one.clicks.map((c) => h("circle", { cx: c.x, cy: c.y, r: photo.width / 130, fill: c.label ? COLORS[i % 8] : "#fff", stroke: c.label ? "#fff" : COLORS[i % 8], "stroke-width": photo.width / 400 }))))),
        h("div", { class: "head" }, "Things"),
        h("div", { class: "stack" }, things.map((one, i) => h("div", { class: "row", key: `t${i}` },
          h("input", { type: "radio", name: "thing", checked: i === at, "aria-label": `Mark ${one.name}`, onchange: () => { at = i; show(); } }),
          h("span", { class: "dot", style: `background:${COLORS[i % 8]}` }),
          h("input", { type: "text", value: one.name, "aria-label": `Name ${i + 1}`, oninput: (e) => { one.name = e.target.value; show(); }, onfocus: () => { if (at !== i) { at = i; show(); } }, onchange: show }),
          h("span", { class: "muted num", style: "white-space:nowrap" }, say(one.clicks.length, "click")),
          button("Clear", () => { one.clicks = []; show(); }, { class: "b quiet small" }),
          things.length > 1 ? button("Remove", () => { things.splice(i, 1); at = Math.min(at > i ? at - 1 : at, things.length - 1); show(); }, { class: "b quiet small" }) : null)),
        h("div", {}, button("Another thing", () => { things.push({ name: `object_${things.length + 1}`, clicks: [] }); at = things.length - 1; show(); }, { class: "b small" }))),
        h("div", { class: "head" }, "What shall happen?"),
        h("textarea", { rows: 2, "aria-label": "Sentence", placeholder: "For example: the ball rolls to the right and hits the box", value: prompt, oninput: (e) => { prompt = e.target.value; show(); } }),
      ],
    ], photo ? [h("span", { class: "muted grow", "aria-live": "polite" }, lacks()), button("Another photo", () => { photo = null; show(); }), button("Start", begin, { class: "b main", disabled: !ready() })] : null);
  }

  on("run", ({ session }) => {
    if (!sent || session === sent.session) return;
    [sent, photo, prompt, problem] = [null, null, "", ""];
  });
  on("notices", (all) => {
    if (!sent || newest(all) <= sent.error) return;
    const one = all.find((item) => item.id === newest(all));
    send({ do: "dismiss", id: one.id });
    refused(one.text);
  });
  on("say", (one) => { if (sent && one.level === "error") refused(one.text); });
  on("library", () => { if (kind === "open") show(); });
  // A click on the photo takes the focus out of the dialog; Escape closes it all the same.
  addEventListener("keydown", (event) => { if (event.key === "Escape" && kind && !host.contains(document.activeElement)) close(); });
  const enter = (next, first) => {
    from = from || document.activeElement;
    kind = next;
    show();
    host.querySelector(first)?.focus();
  };
  return { open: () => { send({ do: "list_sessions" }); shelf.reset(); enter("open", ".body .b.main"); }, fresh: () => enter("new", ".body input, .body textarea") };
}
