// Dialogs: open a case or a session, and a new session from a photo.

import { button, COLORS, draw, dropping, h, keepInside, say, SECOND_CLICK } from "./dom.js";
import { thumbnail } from "./photo_draw.js";
import { makeShelf } from "./shelf.js";
import { on, send, value } from "./wire.js";

const MAX_PHOTO = 16 * 2 ** 20, LONGEST = 4000;

const unmarked = (name) => ({ name: name.replaceAll("_", " "), clicks: [], box: null, typed: false, masks: [], candidate: 0 });
const isMarked = (one) => one.box !== null || one.clicks.length > 0;

export function startDialogs(host) {
  let kind = "";
  let photo = null; // { file, url, data, width, height }
  let things = [unmarked("object")];
  let at = 0;
  let prompt = "";
  let problem = "";
  let latest = null; // the thing that was marked last: its masks stay until the next is marked
  let drag = null; // the box being drawn: { from, to }, pixels of the photo
  let ticket = 0; // of the newest question which things the sentence names

  let sent = null; // a photo on its way: in which session it was sent, and the newest error then
  let from = null; // what had the focus before the dialog

  let closed = -Infinity; // when the dialog was closed, ms
  const close = () => { kind = ""; draw(host); from?.focus?.({ preventScroll: true }); [from, closed] = [null, performance.now()]; };
  // The second click of a double click that closed it was not meant for what lay beneath.
  addEventListener("click", (event) => { if (event.detail > 1 && performance.now() - closed < SECOND_CLICK) event.stopPropagation(); }, true);
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
    things = [unmarked("object")];
    at = 0;
    send({ do: "sketch", photo: photo.data });
    show();
    if (prompt) ask();
    // The field that had the focus is gone.
    host.querySelector("textarea")?.focus({ preventScroll: true });
  }

  function spot(event) {
    const box = event.currentTarget.getBoundingClientRect();
    const inside = (value, most) => Math.round(Math.min(Math.max(value, 0), most) * 10) / 10;
    return { x: inside(((event.clientX - box.left) / box.width) * photo.width, photo.width), y: inside(((event.clientY - box.top) / box.height) * photo.height, photo.height) };
  }

  function press(event) {
    event.currentTarget.setPointerCapture?.(event.pointerId);
    const from = spot(event);
    drag = { from, to: from, outside: event.shiftKey || event.button === 2 };
  }

  function pull(event) {
    if (!drag) return;
    drag.to = spot(event);
    if (isBox(drag)) show();
  }

  // A drag is a box around the thing, and the next one's turn comes; anything shorter is a click.
  function release(event) {
    if (!drag) return;
    const one = things[at], done = { ...drag, to: spot(event) };
    drag = null;
    if (isBox(done) && !done.outside) {
      one.box = sides(done);
      one.clicks = one.clicks.filter((c) => !c.label || holds(one.box, c));
      const next = things.findIndex((other) => !isMarked(other));
      if (next >= 0) at = next;
    } else one.clicks.push({ ...done.from, label: done.outside ? 0 : 1 });
    [one.masks, one.candidate, one.picked] = [[], 0, false];
    latest = one;
    look(one);
    // A mask that was chosen is sought again: what another thing covers may not be offered now.
    for (const other of things) if (other !== one && other.candidate) look(other);
    show();
  }

  // The masks of what is marked, one thing after the other; what was chosen stays if it is still there.
  let queue = [], asked = null, sketches = 0;
  function look(one) {
    if (!queue.includes(one)) queue.push(one);
    next();
  }
  function next() {
    if (asked || !queue.length || kind !== "new") return;
    const one = queue.shift();
    if (!isMarked(one) || !things.includes(one)) return next();
    const said = things.filter(isMarked).map((each, i) => [each === one ? "wanted" : `other_${i}`, { points: each.clicks, box: each.box }]);
    asked = { one, ticket: ++sketches, wanted: one.masks[one.candidate]?.path };
    one.looking = true;
    if (!send({ do: "sketch_masks", name: "wanted", said, ticket: asked.ticket })) asked = null;
    show();
  }
  function found(answer) {
    if (!asked || answer.ticket !== asked.ticket) return;
    const { one, wanted } = asked;
    asked = null;
    one.looking = false;
    one.masks = answer.masks || [];
    one.candidate = Math.max(0, one.masks.findIndex((mask) => mask.path === wanted));
    if (kind === "new") show();
    next();
  }

  const SHORT = 0.012; // of the photo's width: what is dragged less far is a click
  const isBox = ({ from, to }) => Math.min(Math.abs(to.x - from.x), Math.abs(to.y - from.y)) > SHORT * photo.width;
  const sides = ({ from, to }) => [Math.min(from.x, to.x), Math.min(from.y, to.y), Math.max(from.x, to.x), Math.max(from.y, to.y)];
  const holds = ([x0, y0, x1, y1], c) => c.x >= x0 && c.x <= x1 && c.y >= y0 && c.y <= y1;

  // The things that the sentence names wait to be marked; what a person named or marked stays.
  function ask() { send({ do: "names", prompt: prompt.trim().slice(0, LONGEST), ticket: ++ticket }); }
  let waiting = 0;
  function askSoon() { clearTimeout(waiting); waiting = setTimeout(ask, 350); }

  function offered(answer) {
    if (answer.ticket !== ticket || !answer.names || kind !== "new") return;
    const own = things.filter((one) => isMarked(one) || (one.typed && one.name.trim()));
    const blank = own.find((one) => isAuto(one.name) && isMarked(one));
    const fresh = answer.names.filter((name) => !own.some((one) => tidy(one.name) === name));
    if (blank && fresh.length) blank.name = fresh.shift().replaceAll("_", " ");
    const current = things[at];
    things = [...own, ...fresh.map((name) => unmarked(name))];
    if (!things.length) things = [unmarked("object")];
    const first = things.findIndex((one) => !isMarked(one));
    at = things.includes(current) ? things.indexOf(current) : Math.max(first, 0);
    show();
  }

  // What keeps it from starting, in words; "" where nothing does.
  function lacks() {
    const wrong = things.find((one) => isMarked(one) && !/^[A-Za-z0-9_][A-Za-z0-9_-]{0,63}$/.test(tidy(one.name)));
    if (wrong) return `“${wrong.name}” cannot be a name: letters from a to z, digits, - and _, at most 64.`;
    if (prompt.length > LONGEST) return `The sentence has ${prompt.length} characters; at most ${LONGEST} are allowed.`;
    if (!prompt.trim()) return "Say what shall happen, in a sentence.";
    const unnamed = things.findIndex((one) => isMarked(one) && isAuto(one.name) && !prompt.toLowerCase().includes(one.name.trim().replaceAll("_", " ")));
    return unnamed < 0 ? "" : `Call thing ${unnamed + 1} what the sentence calls it, so that it is known which one is meant.`;
  }
  const ready = () => photo && !lacks();
  const isAuto = (name) => /^object(_\d+)?$/.test(tidy(name));
  const tidy = (name) => name.trim().replace(/\s+/g, "_");

  // A second click comes before the dialog is gone.
  function begin() {
    if (kind !== "new" || !ready()) return;
    const objects = things.filter(isMarked).map((one) => [tidy(one.name), { points: one.clicks, box: one.box, candidate: one.masks[one.candidate]?.candidate || 0, settled: Boolean(one.picked && one.masks.length) }]);
    if (!send({ do: "new", photo: photo.data, prompt: prompt.trim(), objects })) return;
    sent = { session: value("run")?.session, error: newest(value("notices") || []) };
    problem = "";
    close();
  }

  const newest = (notices) => Math.max(0, ...notices.filter((one) => one.level === "error").map((one) => one.id));

  // What could not be begun comes back as it was, with the reason.
  function refused(text) {
    sent = null;
    text = text.replace(/\S*\b[0-9a-f]{24}\.(png|jpg|webp)/, "the photo"); // the name that it is kept by
    problem = text.charAt(0).toUpperCase() + text.slice(1);
    enter("new", "textarea");
  }

  function fresh() {
    shell("New session from a photo", [
      problem ? h("div", { class: "strip bad", style: "margin-bottom:10px" }, problem) : null,
      !photo ? h("label", { class: "entry drop", ...dropping(take) },
        h("span", { class: "muted" }, h("b", {}, "Choose a photo"), " or drop one here · PNG, JPEG or WebP"), h("input", { type: "file", accept: "image/png,image/jpeg,image/webp", "aria-label": "Photo", onchange: (e) => take(e.target.files[0]) })) : [
        h("div", { class: "head" }, "What shall happen?"),
        h("textarea", { rows: 2, "aria-label": "Sentence", placeholder: "For example: the ball rolls to the right and hits the box", value: prompt, oninput: (e) => { prompt = e.target.value; askSoon(); show(); } }),
        h("div", { class: "beside" },
          h("div", {},
            h("p", { class: "muted", style: "margin:0 0 8px;min-height:3em" }, things[at].box ? "A new drag replaces the box of " : "Drag a box around ", h("b", {}, things[at].name), things[at].box ? "." : " in the photo.", " A click adds a point of it instead, a right click or Shift+click what does not belong to it.", isMarked(things[at]) ? "" : " What you leave out is looked for by its name."),
            h("div", { class: "photo", style: `cursor:crosshair;touch-action:none;margin-inline:auto;width:min(100%, ${(38 * photo.width / photo.height).toFixed(2)}vh)`, "data-photo": true, onpointerdown: press, onpointermove: pull, onpointerup: release, onpointercancel: () => { drag = null; show(); }, oncontextmenu: (e) => e.preventDefault() },
              h("img", { src: photo.url, alt: "Your photo", draggable: "false" }),
              h("svg", { viewBox: `0 0 ${photo.width} ${photo.height}`, preserveAspectRatio: "none", "pointer-events": "none" }, things.flatMap(marks), drag && isBox(drag) ? frame(sides(drag), COLORS[at % 8], "drag") : null)),
            chosen()),
          h("div", {},
            h("div", { class: "head" }, "Things"),
            h("div", { class: "stack" }, things.map((one, i) => h("div", { class: "row wrap", key: `t${i}`, style: "gap:4px 8px" },
              h("input", { type: "radio", name: "thing", checked: i === at, "aria-label": `Mark ${one.name}`, onchange: () => { at = i; show(); } }),
              h("span", { class: "dot", style: `background:${COLORS[i % 8]}` }),
              h("input", { type: "text", value: one.name, style: "flex:1 1 110px;min-width:0", "aria-label": `Name ${i + 1}`, oninput: (e) => { one.name = e.target.value; one.typed = true; show(); }, onfocus: () => { if (at !== i) { at = i; show(); } }, onchange: show }),
              h("span", { class: "row", style: "gap:2px;margin-left:auto" },
                h("span", { class: "muted num", style: "white-space:nowrap" }, one.box ? "a box" + (one.clicks.length ? `, ${say(one.clicks.length, "click")}` : "") : one.clicks.length ? say(one.clicks.length, "click") : "not marked"),
                isMarked(one) ? button("Clear", () => { one.clicks = []; one.box = null; one.masks = []; one.candidate = 0; show(); }, { class: "b quiet small" }) : null,
                things.length > 1 ? button("Remove", () => { things.splice(i, 1); at = Math.min(at > i ? at - 1 : at, things.length - 1); show(); }, { class: "b quiet small" }) : null))),
            h("div", {}, button("Another thing", () => { things.push({ ...unmarked(`object ${things.length + 1}`), typed: true }); at = things.length - 1; show(); }, { class: "b small" }))))),
      ],
    ], photo ? [h("span", { class: "muted grow", "aria-live": "polite" }, lacks()), button("Another photo", () => { photo = null; show(); }), button("Make the scene", begin, { class: "b main", disabled: !ready() })] : null);
  }

  // What was cut out of the thing that is being marked, and the other ways to cut it out.
  function chosen() {
    const one = isMarked(things[at]) ? things[at] : latest;
    if (!one || !things.includes(one) || !isMarked(one)) return null;
    const data = { image: photo.url, size: [photo.width, photo.height] };
    return h("div", { class: "sketch-masks", role: "group", "aria-label": `Masks of ${one.name}`, key: "masks" },
      h("p", { class: "muted", role: "status" }, (one.looking || queue.includes(one)) && !one.masks.length ? `Cutting out ${one.name}…` : one.masks.length ? ["Is the whole of ", h("b", {}, one.name), " cut out, and nothing else? Click the mask that is right", one !== things[at] ? "." : one.box ? ", or drag the box anew." : ", or drag a box around it."] : "Nothing stands out there; try another box."),
      one.masks.length ? h("div", { class: "photo-masks" }, one.masks.map((mask, i) => h("button", { key: `m${i}`, type: "button", "aria-pressed": String(i === one.candidate), "aria-label": `Mask ${i + 1} of ${one.name}`, title: i === one.candidate && one.picked ? "You said that it is right" : "It is this one", onclick: () => { one.candidate = i; one.picked = true; show(); } }, thumbnail(data, mask), h("span", { class: "n" }, i + 1)))) : null);
  }

  // What is marked of a thing: its box, and its clicks.
  function marks(one, i) {
    const color = COLORS[i % 8];
    const mask = one.masks[one.candidate];
    return [
      mask ? h("path", { d: mask.path, "fill-rule": "evenodd", fill: color, "fill-opacity": 0.35, stroke: color, "stroke-width": photo.width / 400 }) : null,
      one.box ? frame(one.box, color, `b${i}`) : null,
      ...one.clicks.map((c) => h("circle", { cx: c.x, cy: c.y, r: photo.width / 130, fill: c.label ? color : "#fff", stroke: c.label ? "#fff" : color, "stroke-width": photo.width / 400 })),
    ];
  }
  const frame = ([x0, y0, x1, y1], color, key) => h("rect", { key, x: x0, y: y0, width: x1 - x0, height: y1 - y0, fill: color, "fill-opacity": 0.12, stroke: color, "stroke-width": photo.width / 300 });

  on("names", offered);
  on("sketch", found);
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
