// Inspector: a form for what is selected, as the server describes it.

import { dial } from "./dial.js";
import { button, draw, h, iconButton } from "./dom.js";
import { on, retime, send, setField, value } from "./wire.js";

const COUNTED = { value: "a strength", acceleration: "an acceleration", target_speed: "a speed to reach", body: "the middle of the thing", world: "the scene's origin" };
const TICKS = { Muted: "It is kept, and does nothing", "Must not happen": "The opposite is demanded", "Known for certain": "No repair changes the camera" };
const AIMED = "strength and aim"; // a vector by meaning, not by three numbers
const HELD = [
  ["stands", "Stands", "It stands on something when the event begins"],
  ["hangs", "Hangs", "It stays in the air until the first action on it begins"],
  ["floats", "Floats", "It has no weight: it stays in the air, and goes on where it is pushed"],
  ["falls", "Falls", "Nothing holds it: it falls as soon as the event begins"],
];

export function startInspector(host) {
  let data = null;
  const show = () => data && draw(host, page());

  // Nothing is selected: all that can be.
  function nothing() {
    const row = (kind, name, text, note) => h("button", { class: "b quiet row", type: "button", key: `${kind} ${name}`, style: "text-align:left", title: "Show its numbers", onclick: () => send({ do: "select", kind, name }) }, h("span", { class: "grow" }, text), note ? h("span", { class: "chip" }, note) : null);
    const named = (name) => name.replaceAll("_", " ");
    const things = (value("scene")?.things || []).filter((one) => one.kind !== "landmark"), lanes = value("timeline")?.lanes || [];
    const acting = lanes.flatMap((lane) => lane.actions.map((one) => row("action", one.id, one.label, named(lane.name))));
    return [h("p", { class: "muted" }, "Choose something here, in the scene, on the timeline or in the photo to see and change its numbers."),
      things.length ? [h("div", { class: "head" }, "Things"), h("div", { class: "stack", style: "gap:2px" }, things.map((one) => row(one.kind, one.name, named(one.name), named(one.material))))] : null,
      acting.length ? [h("div", { class: "head" }, "What acts on them"), h("div", { class: "stack", style: "gap:2px" }, acting)] : null];
  }

  function page() {
    if (data.kind === "none") return nothing();
    return [
      h("div", { class: "row" }, h("div", { class: "title grow" }, data.kind === "action" ? `${data.title} · ${data.name.replaceAll("_", " ")}` : data.title || data.name),
        ["action", "statement", "object", "support"].includes(data.kind) && !data.readOnly ? button("Delete", () => send({ do: "remove", path: data.path }), { class: "b quiet small bad" }) : null),
      data.help ? h("p", { class: "faint", style: "margin:2px 0 10px" }, data.help) : null,
      data.facts && data.facts.length ? h("div", { class: "facts strip num", style: "margin-bottom:12px" }, data.facts.map((one) => [h("span", { class: "muted" }, one.what), h("span", {}, one.is, " ", h("span", { class: "faint" }, one.unit))])) : null,
      data.kind === "object" && !data.readOnly && later() ? button("It should be elsewhere now…", () => send({ do: "show", what: "gizmo", on: true }), { class: "b small", style: "margin-bottom:10px", title: "Drag the handle in the scene to where it should be at this frame; a repair that brings it there is searched" }) : null,
      data.pace ? pace(data.pace) : null,
      data.hold ? hold(data.hold) : null,
      h("div", { class: "form", key: data.path }, data.fields.map((one) => field(one))),
      data.actions && data.actions.length ? [h("div", { class: "head" }, "Actions"), h("div", { class: "row wrap" }, data.actions.map((id) => button(id.replaceAll("_", " "), () => send({ do: "select", kind: "action", name: id }), { class: "b small" })))] : null,
    ];
  }

  // How a thing is held when the event begins; in the air it keeps its place in the photo.
  function hold(one) {
    const off = data.readOnly, set = (how) => send({ do: "hold", name: data.name, how });
    return h("div", { class: "form", key: "hold", role: "group", "aria-label": "How it is held" },
      h("div", { class: "wide row", style: "gap:4px" }, HELD.map(([how, text, about]) => button(text, () => set(how), { class: "b small grow", "aria-pressed": String(one.how === how), disabled: off, title: about }))),
      one.how === "stands" ? [h("label", { class: "label" }, "Stands on"),
        h("select", { "aria-label": "Stands on", value: one.on || "", disabled: off, onchange: (e) => put({ path: `${data.path}.support` }, e.target.value || null) },
          one.on ? null : h("option", { value: "" }, "not known"), one.others.map((name) => h("option", { value: name }, name.replaceAll("_", " "))))] : null,
      one.height === null ? null : [h("label", { class: "label", title: "Along its line of sight: it stays in its place in the photo" }, "Above the ground"),
        h("div", { class: "num-with-unit" }, h("input", { type: "text", inputmode: "decimal", "aria-label": "Height above the ground in metres", value: neat(one.height), disabled: off, onchange: (e) => { const height = read(e.target, false); if (height !== null && height >= 0) send({ do: "raise", name: data.name, height }); else show(); } }), h("span", { class: "unit" }, "m"))]);
  }

  // The clip's pace: a usual one, or a number of one's own; what is chosen is pinned.
  function pace(one) {
    const off = data.readOnly, usual = one.offered.findIndex((each) => each.on);
    const ask = (factor) => { if (!retime(factor, () => show())) show(); };
    const type = (e) => {
      const factor = Number(e.target.value.replace(",", "."));
      if (factor >= 0.25 && factor <= 4) ask(factor);
      else e.target.classList.add("wrong");
    };
    return h("div", { class: "form pace-form", key: "pace", role: "group", "aria-label": "Pace" },
      h("label", { class: "label row", style: "gap:3px" }, h("span", { class: "grow" }, "Pace"),
        iconButton("pin", one.pinned ? "Unpin: the planner may choose the pace" : "Pin: the planner keeps this pace", () => (one.pinned ? one.paths.forEach((path) => send({ do: "pin", path, on: false })) : ask(one.factor)), { "aria-pressed": String(one.pinned), disabled: off, style: `width:18px;height:18px;${one.pinned ? "" : "opacity:.35"}` })),
      h("select", { "aria-label": "Pace of the clip", value: String(usual), disabled: off, onchange: (e) => { if (Number(e.target.value) >= 0) ask(one.offered[Number(e.target.value)].factor); } },
        usual < 0 ? h("option", { value: "-1" }, one.text) : null, one.offered.map((each, i) => h("option", { value: String(i) }, each.factor === 1 ? each.text : `${each.text} of real time`))),
      h("label", { class: "label" }, "Factor"),
      h("div", { class: "num-with-unit" },
        h("input", { type: "text", inputmode: "decimal", value: String(Number(one.factor.toPrecision(3))), "aria-label": "Time factor", title: "0.25 to 4; less than 1 is slow motion", disabled: off, oninput: (e) => e.target.classList.remove("wrong"), onchange: type }),
        h("span", { class: "unit" }, "× real time")),
      h("p", { class: "wide faint", style: "font-size:12px" }, one.pinned ? "Chosen by hand and pinned: the planner changes other things." : "Starts, lengths and windows keep their seconds. What is chosen is pinned."));
  }

  const later = () => { const head = value("playhead"); return Boolean(head && head.ready && head.step > 0); };
  const put = (one, next) => setField(one.path, next, () => show());

  function field(one) {
    if (one.kind === "const" || one.kind === "data") return null;
    const wide = one.kind === "vector" && Array.isArray(one.value) ? " wide" : "";
    const label = h("label", { class: `label row${wide}`, style: "gap:3px", title: one.label }, h("span", { class: "grow" }, one.label), pin(one));
    if (one.kind === "group" && one.value !== null && one.value !== undefined) return [h("div", { class: "label wide head", style: "margin:6px 0 0" }, one.label), h("div", { class: "sub form" }, one.fields.map(field))];
    if (one.kind === "choice") return choice(one, label);
    return [label, h("div", { class: wide }, control(one)), warning(one.path)];
  }

  // What is allowed, and still far from what is usual.
  const warning = (path) => (data.warnings?.[path] ? h("p", { class: "wide warn-note", role: "status" }, data.warnings[path]) : null);

  function pin(one) {
    if (one.pinned === undefined) return null;
    return iconButton("pin", one.pinned ? "Unpin" : "Pin: the planner never changes this", () => send({ do: "pin", path: one.path, on: !one.pinned }), { "aria-pressed": String(one.pinned), style: `width:18px;height:18px;${one.pinned ? "" : "opacity:.35"}` });
  }

  function choice(one, label) {
    const at = which(one);
    const chosen = one.choices[at];
    const pick = one.choices.length > 1 || one.optional
      ? h("select", { "aria-label": `${one.label}: kind`, value: String(at), disabled: data.readOnly, onchange: (e) => put(one, start(one, one.choices[Number(e.target.value)])) },
        one.optional ? h("option", { value: "-1" }, one.path.endsWith(".when") ? "at that moment" : "not set") : null,
        one.choices.map((other, i) => h("option", { value: String(i) }, other.title)))
      : null;
    if (!chosen) return [label, pick];
    const inner = { ...one, ...chosen, label: one.label };
    if (chosen.title === AIMED) return [label, pick, h("div", { class: "sub form" }, directed(one, chosen))];
    return [label, pick, chosen.kind === "group" ? h("div", { class: "sub form" }, chosen.fields.map(field)) : h("div", { class: "sub" }, control(inner)), warning(one.path)];
  }

  const AIMS = { toward: "towards", direction: "a direction", along: "the way it moves" };
  const WAYS = { direction: ["left", "right", "up", "down", "away", "toward_camera"], along: ["velocity", "against_velocity"] };

  // A vector by meaning: how strong, where to, and how far aside and up from there. Exactly one
  // aim may be set, so changing it writes the vector as a whole.
  function directed(one, chosen) {
    const v = one.value, off = data.readOnly;
    const part = (name) => chosen.fields.find((each) => each.path.endsWith(`.${name}`));
    const kind = v.toward !== null && v.toward !== undefined ? "toward" : v.along ? "along" : "direction";
    const ways = kind === "toward" ? data.names.places.filter((name) => name !== data.target) : WAYS[kind];
    const aim = (next, way) => put(one, { ...v, toward: null, direction: null, along: null, [next]: way });
    const units = { value: one.unit, acceleration: "m/s²", target_speed: "m/s" };
    const strength = part("magnitude");
    return [
      field({ ...strength, label: "Strength", unit: units[v.quantity] || one.unit }),
      part("quantity") ? field({ ...part("quantity"), label: "Counted as" }) : null,
      h("span", { class: "label" }, "Aims"),
      h("div", { class: "row wrap pair", style: "gap:4px" },
        h("select", { value: kind, disabled: off, "aria-label": `${one.label}: aims`, onchange: (e) => aim(e.target.value, e.target.value === "toward" ? data.names.places.find((name) => name !== data.target) : WAYS[e.target.value][0]) }, Object.entries(AIMS).map(([key, text]) => h("option", { value: key }, text))),
        Array.isArray(v[kind]) ? null : h("select", { value: String(v[kind]), disabled: off, "aria-label": `${one.label}: at what`, onchange: (e) => aim(kind, e.target.value) }, ways.map((way) => h("option", { value: way }, way.replaceAll("_", " "))))),
      Array.isArray(v[kind]) ? field({ ...part(kind), kind: "vector", count: 3, unit: "m", label: "Point" }) : null,
      field({ ...part("elevation"), label: "Upwards", unit: "°" }),
      field({ ...part("azimuth"), label: "Aside", unit: "°" }),
      h("div", { class: "wide" }, aside(part("azimuth"), off)),
    ];
  }

  // The same as a dial: straight up is straight at the aim, the left half is to its left.
  function aside(one, off) {
    const degrees = (angle) => Math.round((((angle * 180) / Math.PI + 450) % 360 - 180) * 10) / 10;
    return h("div", { class: "row" },
      dial({ path: one.path, label: "Aside: dial seen from above", angle: ((90 + (one.value || 0)) * Math.PI) / 180, off, mark: "M32 3v6", valueAt: degrees, put: (to) => put(one, to), redraw: show }),
      h("span", { class: "faint", style: "font-size:12px" }, "seen from above: up is straight at the aim, left is to its left"));
  }

  function which(one) {
    const v = one.value;
    if (v === null || v === undefined) return -1;
    return one.choices.findIndex((c) => (c.tag ? v && v.kind === c.tag : c.kind === "vector" ? Array.isArray(v) : c.kind === "group" ? typeof v === "object" && !Array.isArray(v) : c.kind === "text" || c.kind === "pick" ? typeof v === "string" : c.kind === "number" ? typeof v === "number" : true));
  }

  // A first value when another kind is chosen; a vector keeps its length when it is aimed by meaning.
  function start(one, chosen) {
    if (!chosen) return null;
    if (chosen.title === AIMED && Array.isArray(one.value)) return { ...chosen.seed, magnitude: Number(Math.hypot(...one.value).toPrecision(4)) };
    return chosen.seed;
  }

  function control(one) {
    const off = data.readOnly;
    if (one.kind === "tick") return h("label", { class: "tick", title: TICKS[one.label] || one.label }, h("input", { type: "checkbox", checked: Boolean(one.value), disabled: off, "aria-label": one.label, onchange: (e) => put(one, e.target.checked) }));
    if (one.kind === "pick") return select(one, one.options.map(String), off);
    if (one.kind === "text" && one.names && data.names[one.names]) return select(one, (one.names === "supports" ? [...data.names.supports, ...data.names.objects, "air"] : data.names[one.names]).filter((name) => name !== own(one)), off);
    if (one.kind === "vector") return vector(one, off);
    if (one.kind === "number") {
      const scale = scaleOf(one), bound = (at) => Number((at * scale).toPrecision(4));
      const help = [one.min !== null && one.min !== undefined ? `from ${bound(one.min)}` : "", one.max !== null && one.max !== undefined ? `to ${bound(one.max)}` : ""].filter(Boolean).join(" ");
      return h("div", { class: "num-with-unit" },
        h("input", { type: "text", inputmode: "decimal", value: one.value === null || one.value === undefined ? "" : neat(one.value * scaleOf(one)), placeholder: one.empty || (one.optional ? "not set" : ""), "aria-label": one.label, title: help, disabled: off,
          oninput: (e) => e.target.classList.remove("wrong"), onchange: (e) => number(one, e.target), onkeydown: nudge(one) }),
        one.unit ? h("span", { class: "unit" }, one.unit === "steps" ? "s" : one.unit) : null,
        one.optional && one.value !== null && !off ? h("button", { class: "b quiet small", type: "button", title: "Back to the default", "aria-label": `Reset ${one.label}`, onclick: () => put(one, null) }, "↺") : null);
    }
    return h("input", { type: "text", value: one.value === null || one.value === undefined ? "" : String(one.value), "aria-label": one.label, disabled: off, onchange: (e) => put(one, e.target.value) });
  }

  // No thing stands on itself or touches itself.
  const own = (one) => (data.kind === "object" ? data.name : ["subject", "a"].some((part) => one.path.endsWith(`.${part}`)) ? null : data.data?.subject ?? null);

  function select(one, options, off) {
    return h("select", { value: one.value === null || one.value === undefined ? "" : String(one.value), "aria-label": one.label, disabled: off, onchange: (e) => put(one, e.target.value === "" ? null : e.target.value) },
      one.optional || one.value === null ? h("option", { value: "" }, "not set") : null, options.map((name) => h("option", { value: name }, (/[.](quantity|point_frame)$/.test(one.path) && COUNTED[name]) || name.replaceAll("_", " "))));
  }

  function read(input, whole) {
    const text = input.value.trim().replace("−", "-").replace(",", ".");
    const value = Number(text);
    const good = text !== "" && Number.isFinite(value) && (!whole || Number.isInteger(value));
    input.classList.toggle("wrong", !good);
    return good ? value : null;
  }

  function number(one, input) {
    if (input.value.trim() === "" && one.optional) return put(one, null);
    const scale = scaleOf(one), typed = read(input, one.whole && scale === 1);
    const value = typed === null || scale === 1 ? typed : Math.round(typed / scale);
    if (value === null) return refuse(one, input.value);
    if (value !== one.value) setField(one.path, value, () => { input.value = neat(one.value * scale); });
    else input.value = neat(one.value * scale);
  }

  // Steps are the program's own; a person is shown seconds of the event.
  const timeOf = () => value("timeline");
  const scaleOf = (one) => (one.unit === "steps" ? timeOf()?.stepSeconds || 1 : 1);

  const neat = (value) => (typeof value === "number" ? String(Number(value.toPrecision(6))) : String(value));

  const refuse = (one, text) => send({ do: "edit", edits: [{ op: "set", path: one.path, value: text }], ticket: 0 });

  const nudge = (one) => (event) => {
    if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
    const value = read(event.target, false);
    if (value === null) return;
    event.preventDefault();
    const steps = value === null ? null : scaleOf(one);
    const unit = (steps !== 1 ? steps * (timeOf()?.stepsPerFrame || 1) : one.whole ? 1 : Math.max(0.001, 10 ** Math.floor(Math.log10(Math.abs(value) || 1)) / 10)) * (event.shiftKey ? 10 : 1);
    event.target.value = String(Number((value + (event.key === "ArrowUp" ? unit : -unit)).toPrecision(8)));
    number(one, event.target);
  };

  function vector(one, off) {
    const parts = Array.isArray(one.value) ? one.value : [];
    const names = one.count === 4 ? ["w", "x", "y", "z"] : ["x", "y", "z"];
    if (!parts.length) return h("div", { class: "row" }, h("span", { class: "muted grow" }, "not set"), off ? null : button("Set", () => put(one, Array.from({ length: one.count }, () => 0)), { class: "b small" }));
    return h("div", { class: "stack", style: "gap:4px" },
      h("div", { class: "vec" }, parts.map((part, i) => h("input", { type: "text", inputmode: "decimal", value: String(Number(part.toPrecision(5))), "aria-label": `${one.label} ${names[i]}`, title: names[i], disabled: off,
        onchange: (e) => { const v = read(e.target, false); if (v === null) refuse(one, e.target.value); else if (!raised(one, i, v - part)) put(one, parts.map((old, at) => (at === i ? v : old))); } })),
        one.unit ? h("span", { class: "unit" }, one.unit) : null),
      one.count === 3 && ["force", "velocity", "torque"].some((w) => one.path.endsWith(w)) ? heading(one, parts, off) : null);
  }

  // A thing in the air of a photo is raised along its line of sight, so that it stays in its place there.
  function raised(one, axis, by) {
    const height = data.hold?.height;
    if (axis !== 2 || !one.path.endsWith(".position") || height === undefined || height === null || height + by < 0) return false;
    send({ do: "raise", name: data.name, height: height + by });
    return true;
  }

  // Direction seen from above: drag the needle; the length in the plane stays.
  function heading(one, parts, off) {
    const flat = Math.hypot(parts[0], parts[1]);
    const turned = (angle) => [...[flat * Math.cos(angle), flat * Math.sin(angle)].map((part) => Number(part.toPrecision(5))), parts[2]];
    return h("div", { class: "row" },
      dial({ path: one.path, label: `${one.label}: direction seen from above`, angle: Math.atan2(parts[1], parts[0]), off: off || !flat, valueAt: turned, put: (to) => put(one, to), redraw: show }),
      h("span", { class: "faint", style: "font-size:12px" }, `${Math.hypot(...parts).toPrecision(3)} ${one.unit}, seen from above: right is right in the photo, up is away from the camera`));
  }

  on("inspector", (next) => { data = next; show(); });
  for (const listed of ["scene", "timeline"]) on(listed, () => { if (data?.kind === "none") show(); });
}
