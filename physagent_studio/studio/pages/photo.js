// Photo: the picture with its objects, and the tools that correct what was read off it.

import { button, draw, h } from "./dom.js";
import { live, marks, outlines, thumbnail } from "./photo_draw.js";
import { HOW, makePhotoKeys } from "./photo_keys.js";
import { makeTools, TOOLS } from "./photo_tools.js";
import { startStage } from "./photo_view.js";
import { on, send, value } from "./wire.js";

const ICONS = {
  look: "M3 2l9 6-4 1-2 4z", mask: "M7.300 2h1.400v5.300H14v1.400H8.700V14H7.300V8.700H2V7.300h5.300z", brush: "M13.500 2.500c-3 1.500-5.500 4-6.500 6l1 1c2-1 4.500-3.500 6-6.500zM6.500 9.500C5 9.500 4 10.500 4 12c0 .8-.7 1.300-1.500 1.500C5 14 7.500 13 7.500 10.500z",
  scissors: "M4.500 3l4 5.200L12.500 3l1 .7-4.200 5.500.8 1.100a2 2 0 1 1-1 .8L8.500 10.300l-.6.8a2 2 0 1 1-1-.8l.7-1.100L3.500 3.700z", horizon: "M2 9h12v1.300H2zM4.500 7.500a3.500 3.500 0 0 1 7 0z", ramp: "M2 13 14 4.500V13z", measure: "M1.500 10.500 10.500 1.500l4 4-9 9zM4 9.500l1.500 1.500M6.500 7l1 1M9 4.500l1.500 1.500", way: "M2 7.200h8V4l4.500 4-4.500 4V8.800H2z", ground: "M2 13h12v1.300H2zM7.300 5h1.400v1.500H7.300zM7.300 7.500h1.400V9H7.300zM7.300 10h1.400v1.500H7.300zM8 1a1.800 1.800 0 1 1 0 3.600A1.800 1.800 0 0 1 8 1z",
};
const LONGEST = 15000; // milliseconds for which the photo stands in for what is not drawn yet
const EFFECTS = { add: "What is marked belongs to the thing", erase: "What is marked does not belong to it", only: "It is exactly what is marked" };
const SHAPES = { sphere: "Ball", ellipsoid: "Ellipsoid", cylinder: "Cylinder", frustum: "Cone or cup", capsule: "Capsule", torus: "Ring", box: "Box", revolved: "Round, by its outline", inflated: "Its outline, rounded", mesh: "Mesh" };

export function startPhoto(host) {
  let data = null;
  let last; // the name of what was selected
  let alike = "", lone = ""; // the thing whose likes are looked for, and one that has none
  let wrong = ""; // the thing whose size cannot be read
  const top = h("div", { class: "photo-top" });
  const middle = h("div", {});
  const bottom = h("div", { class: "stack" });
  // Masks stay in sight below a tall photo.
  const choice = h("div", { class: "photo-choice" });
  host.append(top, middle, choice, bottom);
  const stage = startStage(middle, { onTool: (...all) => tools.on(...all) });
  // Until there is a scene to look at, the photo itself is in the middle of the page.
  const awaited = h("img", { class: "awaited", alt: "Your photo, while its scene is made", hidden: true });
  document.getElementById("viewer").after(awaited);
  let drawing = false;
  const later = () => {
    if (drawing) return;
    drawing = true;
    requestAnimationFrame(() => { drawing = false; show(); });
  };
  const tools = makeTools({ stage, data: () => (data?.image ? data : null), changed: later });
  const { state } = tools;
  const keys = makePhotoKeys({ stage, tools, data: () => (data?.image ? data : null), changed: later });
  stage.scaled(later);

  function show() {
    if (!data) return;
    stage.stage.hidden = !data.image;
    awaited.hidden = !data.image || (data.seen && drawn());
    if (!awaited.hidden && awaited.getAttribute("src") !== data.image) awaited.src = data.image;
    if (!data.image) {
      draw(top, sentence());
      draw(choice);
      return draw(bottom, h("p", { class: "muted" }, "This program has no photo."));
    }
    const chosen = tools.target(), unit = stage.unit();
    stage.show(data.image, data.size);
    stage.stage.setAttribute("aria-label", `Photo. ${TOOLS.find(([key]) => key === state.tool)[2]} ${HOW}`);
    draw(stage.layers.outlines, outlines(data, chosen, state));
    draw(stage.layers.marks, marks(data, chosen, state, unit));
    draw(stage.layers.live, live(data, state, unit), keys.draw(unit));
    draw(top, data.readOnly ? sentence() : toolbar());
    draw(choice, masks());
    draw(bottom, things(chosen), about(chosen));
  }

  // The photo makes way for the scene once that is drawn as a whole: nothing bare is seen before,
  // nor where the viewer is loaded anew in another look.
  let whole = "", since = 0, come = "";
  const viewer = document.getElementById("viewer");
  viewer.addEventListener("load", () => { come = viewer.getAttribute("src"); later(); });
  addEventListener("viewer", () => show());
  function drawn() {
    const view = viewer.contentWindow, names = data.objects.filter((one) => one.path).map((one) => `/objects/${one.name}`);
    const wanted = viewer.getAttribute("src"), scene = `${data.session} ${wanted}`;
    if (whole === scene) return true;
    // A viewer that is still being loaded has drawn nothing; one that cannot say so is not waited for.
    const loaded = view?.location.href !== "about:blank" && view?.document.readyState === "complete";
    const here = come === wanted;
    if (!view || (here && loaded && !view.studioDrawn)) return true;
    since ||= performance.now();
    if (value("scene")?.switches.find((one) => one.what === "photo")?.on !== false) names.push("/around/beyond/0");
    if ((here && view.studioDrawn?.(names)) || performance.now() - since > LONGEST) { [whole, since] = [scene, 0]; return true; }
    setTimeout(later, 100);
    return false;
  }

  const sentence = () => (data.prompt ? h("p", {}, "“", data.prompt, "”") : null);

  function toolbar() {
    const tool = TOOLS.find(([key]) => key === state.tool);
    const needs = ["mask", "brush", "scissors"].includes(state.tool) && !tools.target();
    const effects = state.tool === "brush" ? [["add", "Add"], ["erase", "Erase"]] : [["add", "Add"], ["erase", "Cut away"], ["only", "Exactly this"]];
    return [
      h("div", { class: "photo-tools", role: "toolbar", "aria-label": "Photo tools" },
        TOOLS.map(([key, text, about]) => h("button", { class: "b", type: "button", title: about, "aria-pressed": String(key === state.tool), onclick: () => tools.pick(key) },
          h("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, h("path", { d: ICONS[key], fill: "currentColor" })), text))),
      ["brush", "scissors"].includes(state.tool) ? h("div", { class: "row", style: "gap:8px" },
        h("div", { class: "row", style: "gap:3px", role: "group", "aria-label": "What it does" }, effects.map(([key, text]) => button(text, () => { state.effect = key; show(); }, { title: EFFECTS[key], class: "b small", "aria-pressed": String(state.effect === key) }))),
        state.tool === "brush" ? h("input", { type: "range", min: 1, max: 60, value: String(state.radius), "aria-label": "Brush radius in pixels", class: "grow", oninput: (e) => { state.radius = Number(e.target.value); later(); } }) : null) : null,
      h("p", { class: "photo-hint", "aria-live": "polite" }, needs ? "Choose a thing below first; or mark one, then say which it is." : hint(tool)),
    ];
  }

  function hint([key,, text]) {
    if (key === "ramp" && state.ramp?.length) return ["Now the ground below its upper end.", "Now its upper end."][state.ramp.length - 1];
    if (key === "horizon") return `${text} Now ${data.horizonBy || "not known"}.`;
    return text;
  }

  function masks() {
    const one = state.pending;
    if (!one || (!one.past.length && !one.masks.length && !one.waiting)) return null;
    if (!one.name) return nameless();
    const word = one.name.replaceAll("_", " ");
    return h("div", { key: "masks", role: "group", "aria-label": `Masks of ${word}` },
      h("div", { class: "photo-masks" },
        one.problem ? h("div", { class: "none" }, one.problem) : one.masks.map((mask, i) =>
          h("button", { key: `m${i}`, type: "button", "aria-pressed": String(i === one.chosen), "aria-label": `Mask ${i + 1} of ${word}, score ${mask.score.toFixed(2)}`, disabled: Boolean(one.sent || one.looking),
            onclick: () => tools.take(i), onpointerenter: () => { one.preview = i; later(); }, onpointerleave: () => { one.preview = undefined; later(); } },
            thumbnail(data, mask), h("span", { class: "n" }, i + 1), h("span", { class: "s" }, mask.score.toFixed(2)))),
        !one.problem && !one.masks.length ? h("div", { class: "none" }, one.waiting ? "Looking…" : "Nothing stands out there; try a box, or paint it.") : null),
      h("div", { class: "row", style: "margin-top:6px" },
        h("span", { class: "muted grow", style: "font-size:12px", "aria-live": "polite" }, words(one)),
        one.sent ? null : button("Back", tools.back, { class: "b small quiet", disabled: !one.past.length }), one.sent ? null : button("Drop", tools.drop, { class: "b small quiet" })));
  }

  // Marks that nobody has said the thing of.
  const nameless = () => h("div", { key: "nameless", class: "row", style: "margin-top:8px" },
    h("span", { class: "grow", style: "font-size:12px", role: "status" }, "Which thing is that? Choose it below, or name a new one."),
    button("Back", tools.back, { class: "b small quiet" }), button("Drop", tools.drop, { class: "b small quiet" }));

  // What happens, or what to do, in words.
  function words(one) {
    if (one.sent) return data.seen ? "The scene follows…" : "It is used as soon as the first scene is there…";
    if (one.wanted >= 0) return `Mask ${one.wanted + 1} it is, after a closer look…`;
    if (one.lost) return `Mask ${one.lost} did not last a closer look: choose again.`;
    if (one.waiting && one.soon) return "The best one is taken once it is found…";
    if (one.waiting && !one.more && !one.early) return "Looking…";
    const goesOn = one.early ? "; looking more closely…" : one.more ? "; looking at the whole stack…" : ".";
    return `Press 1–${Math.max(one.masks.length, 1)} or Enter to use one${goesOn}`;
  }

  function things(chosen) {
    return h("div", { key: "things" }, h("div", { class: "head" }, "Things"), h("div", { class: "row wrap photo-things", style: "gap:4px" },
      data.objects.map((one) => h("button", { class: "b small", type: "button", title: "Choose it; the tools then mark it", "aria-pressed": String(one.name === chosen), onclick: () => choose("object", one.name) },
        h("span", { class: "photo-swatch", style: `background:rgb(${one.colour.join(" ")})` }), one.name.replaceAll("_", " "), one.grounding.proposed ? h("span", { class: "faint", title: "Found by its words; mark it to be sure" }, "found by words") : null)),
      data.supports.filter((one) => one.placed).map((one) => h("button", { class: "b small", type: "button", title: "Choose it; the tools then mark it", "aria-pressed": String(one.name === chosen), onclick: () => choose("support", one.name) }, one.name.replaceAll("_", " "))),
      state.fresh ? h("span", { class: "chip accent" }, state.fresh) : null,
      data.readOnly ? null : h("form", { class: "row", style: "gap:3px", onsubmit: (e) => { e.preventDefault(); add(e.target.elements[0]); } },
        h("input", { type: "text", placeholder: "New thing", "aria-label": "Name of a new thing", maxlength: 60, style: "width:92px" }), button("Mark it", null, { class: "b small", type: "submit" }))));
  }

  function choose(kind, name) {
    state.fresh = "";
    if (state.pending?.name && state.pending.name !== name) tools.drop();
    send({ do: "select", kind, name });
  }

  function add(input) {
    const name = input.value.trim().toLowerCase().replace(/[^a-z0-9]+/g, "_").replace(/^_+|_+$/g, "").slice(0, 60);
    if (!name) return input.focus();
    input.value = "";
    tools.begin(name);
  }

  function about(chosen) {
    const one = data.objects.find((item) => item.name === chosen);
    if (!one || data.readOnly || !data.seen) return null;
    const own = data.scale.reference === one.name ? data.scale : null;
    const shapes = one.shapes.includes(one.shape) ? one.shapes : [one.shape, ...one.shapes];
    return h("div", { key: `about-${one.name}`, class: "form photo-about" },
      h("label", { class: "label", title: "Everything else is measured against it" }, "Size"),
      h("div", { class: "num-with-unit" }, h("input", { type: "text", inputmode: "decimal", "aria-label": `Size of ${one.name} in metres`, placeholder: own ? "" : "largest side", value: own?.metres ? String(Number(own.metres.toPrecision(3))) : "", onchange: (e) => size(one, e.target) }), h("span", { class: "unit" }, own ? `m, ${own.source === "person" ? "set by you" : own.source}` : "m")),
      wrong === one.name ? h("p", { class: "wide wrong-note", role: "alert" }, "A length is a number of metres, or one with its unit: 0.25, 25 cm, 250 mm.") : null,
      h("label", { class: "label" }, "Shape"),
      h("div", { class: "row" }, h("select", { "aria-label": `Shape of ${one.name}`, value: one.shape, onchange: (e) => send({ do: "form", name: one.name, kind: e.target.value }) }, shapes.map((kind) => h("option", { value: kind }, (SHAPES[kind] || kind) + (one.covers[kind] ? `, ${one.covers[kind]} %` : "")))),
        button("Next (S)", () => send({ do: "form", name: one.name, kind: null }), { class: "b small", title: "Another shape (S)" })),
      h("label", { class: "label" }, "Others"),
      h("div", {}, button("Mark similar things", () => { alike = one.name; send({ do: "like", name: one.name, ticket: 1 }); }, { class: "b small", title: "What looks like it in the photo becomes a thing of its own" }), lone === one.name ? h("p", { class: "muted", role: "status" }, "Nothing else in the photo looks like it.") : null));
  }

  function size(one, input) {
    const [, digits, unit = "m"] = /^([\d.,]+)\s*(mm|cm|m)?$/i.exec(input.value.trim()) || [];
    const metres = Number((digits || "").replace(",", ".")) * { mm: 0.001, cm: 0.01, m: 1 }[unit.toLowerCase()];
    const good = Number.isFinite(metres) && metres > 0;
    wrong = good || !input.value.trim() ? "" : one.name;
    input.classList.toggle("wrong", Boolean(wrong));
    if (good) send({ do: "size", name: one.name, metres: Number(metres.toPrecision(9)) });
    show();
  }

  // Keys of the tools come before the page's own while something is being made.
  document.addEventListener("keydown", (event) => {
    const field = event.target.closest?.("input, textarea, select");
    if (!data?.image || host.hidden || field) return;
    if (event.target.tagName === "BUTTON" && event.key === "Enter" && !event.target.closest(".photo-masks")) return;
    if (!keys.pressed(event) && tools.key(event) === false && !small(event)) return;
    event.preventDefault();
    event.stopPropagation();
  }, true);

  // With nothing else to leave, Escape leaves the large photo.
  function small({ key }) {
    if (key !== "Escape" || !stage.stage.classList.contains("large")) return false;
    stage.large(false);
    return true;
  }

  on("photo", (next) => {
    // What is being made belongs to the photo that it was begun on.
    const other = data && (data.session !== next.session || data.image !== next.image);
    data = next;
    if (other || next.readOnly) tools.drop();
    tools.settle();
    show();
  });
  on("like", ({ name, found }) => {
    if (!name || name !== alike) return;
    alike = "";
    const boxes = found[name] || [];
    if (boxes.length) send({ do: "alike", name, boxes });
    lone = boxes.length ? "" : name;
    show();
  });
  on("masks", tools.found);
  on("edge", tools.edge);
  on("measured", (told) => { state.measured = told; show(); });
  on("say", (notice) => { if (notice.level === "error") tools.refused(); });
  let told = 0; // the newest of the errors that last
  on("notices", (all) => {
    const newest = Math.max(0, ...all.filter((one) => one.level === "error").map((one) => one.id));
    if (newest > told) tools.refused();
    told = newest;
  });
  on("line", (up) => { if (up) tools.resume(); });
  on("selection", ({ name }) => {
    if (last === name) return;
    [last, wrong] = [name, ""];
    tools.turned();
    show();
  });
  window.addEventListener("photo-tool", (event) => {
    tools.pick(event.detail);
    if (event.detail === "mask") tools.look();
  });
  window.addEventListener("resize", later);
}
