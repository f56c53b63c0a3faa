// Timeline: a lane per object, a bar per action, marks of what happened, and the playhead.

import { button, draw, h, iconButton } from "./dom.js";
import { startMenus } from "./timeline_menu.js";
import { attempt, dropAttempt, edit, endAttempt, on, scrub, scrubBy, send, value } from "./wire.js";

const COLORS = {
  SetVelocity: "#2f6fed", SetAngularVelocity: "#7a5af5", ApplyForce: "#d9482b", ApplyTorque: "#c0398c", ApplyAngledForce: "#d97706",
  ApplyDisturbance: "#0e9384", SetPosition: "#3e7cb1", SetOrientation: "#5c6ac4", FixObject: "#667085",
};
const LANE = 26, MARK = 20, TOP = 31, SPEEDS = [0.125, 0.25, 0.5, 1, 2, 4];

export function startTimeline(host, inspect) {
  const top = h("div", { class: "bar-top", role: "toolbar", "aria-label": "Playback" });
  const box = h("div", { class: "lanes", tabindex: 0, "aria-label": "Actions over time" });
  const svg = h("svg", { class: "tl", role: "application", "aria-label": "Timeline" });
  box.append(svg);
  host.append(top, box);
  let data = null, head = null, drag = null, tip = null, zoom = 1;
  const { actionItems, addItems, closeMenu, openMenu, remove } = startMenus(() => ({ data, head }));

  const gutter = () => Math.min(130, Math.max(84, box.clientWidth * 0.22));
  const width = () => Math.max(50, (box.clientWidth - gutter() - 18) * zoom);
  const x = (step) => gutter() + (step / Math.max(data.steps, 1)) * width();
  const step = (clientX) => {
    const at = (clientX - svg.getBoundingClientRect().left - gutter()) / width();
    return Math.max(0, Math.min(data.steps, Math.round(at * data.steps)));
  };
  const snap = (one, event) => (event.altKey ? one : Math.round(one / data.stepsPerFrame) * data.stepsPerFrame);
  const frames = (one) => Math.round(one / data.stepsPerFrame);
  const seconds = (one) => `${(one * data.stepSeconds).toFixed(2)} s`;

  // --- transport ------------------------------------------------------------------------------

  function transport() {
    if (!head) return;
    draw(top,
      iconButton("first", "To the start (Home)", () => scrub(0), { "data-end": "first" }),
      iconButton("back", "One frame back (←)", () => scrubBy(-1)),
      iconButton(head.playing ? "pause" : "play", head.playing ? "Pause (Space)" : "Play (Space)", () => send({ do: "play" }), { class: "b main icon", disabled: !head.ready }),
      iconButton("on", "One frame on (→)", () => scrubBy(1)),
      iconButton("last", "To the end (End)", () => scrub(head.frames - 1), { "data-end": "last" }),
      iconButton("loop", "Repeat (L)", () => send({ do: "loop", on: !head.loop, start: head.loopStart, end: head.loopEnd }), { "aria-pressed": String(head.loop) }),
      h("select", { value: String(head.speed), "aria-label": "Speed", title: "Playback; 1× is as the clip is shown", style: "width:62px", onchange: (e) => send({ do: "speed", factor: Number(e.target.value) }) },
        SPEEDS.map((one) => h("option", { value: String(one) }, one < 1 ? `1/${1 / one}×` : `${one}×`))),
      h("span", { class: "num clip", title: `Seconds of the event, and the frame that is on view; in the video this is at ${head.video.toFixed(2)} s`, "data-frame": head.frame }, `${head.seconds.toFixed(2)} s`, h("span", { class: "muted" }, ` · frame ${head.frame} of ${head.frames - 1}`)),
      h("span", { class: "grow" }),
      zoom > 1 ? button("1:1", () => zoomBy(1 / zoom), { class: "b small quiet", "aria-label": "Whole clip", title: "Show the whole clip (Ctrl and wheel, + and − zoom)" }) : null,
      button("Zoom", () => zoomBy(1.5), { class: "b small quiet hide-medium", "aria-label": "Zoom in", style: "flex:none", title: "Zoom in (Ctrl and wheel, + and −)" }),
      button("+ Action", (e) => openMenu(e, addItems()), { class: "b small", disabled: !data || data.readOnly || !data.lanes.length, "aria-label": "Add an action" }));
  }

  // --- drawing --------------------------------------------------------------------------------

  // Actions of one lane that would cover each other get rows of their own.
  let tops = [], rows = new Map();

  function stack() {
    tops = [TOP];
    rows = new Map();
    for (const lane of data.lanes) {
      const ends = [];
      for (const one of [...lane.actions].sort((a, b) => a.start - b.start)) {
        let row = ends.findIndex((end) => end <= one.start);
        if (row < 0) row = ends.length;
        // A short one needs room for its mark.
        ends[row] = one.start + Math.max(one.duration, Math.ceil(data.steps / 40));
        rows.set(one.id, row);
      }
      tops.push(tops[tops.length - 1] + LANE * Math.max(1, ends.length));
    }
  }

  const tall = (at) => tops[at + 1] - tops[at];
  const rowOf = (id) => LANE * (rows.get(id) || 0);

  function lanes() {
    if (!data) return;
    const height = Math.max(tops[tops.length - 1], TOP + LANE) + 6;
    svg.setAttribute("height", height);
    svg.style.width = `${gutter() + width() + 18}px`;
    // Ticks at round seconds of the event, far enough apart to be read.
    const whole = data.steps * data.stepSeconds;
    const every = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20].find((one) => (one / whole) * width() >= 44) || 60;
    const marks = [];
    for (let at = 0; at <= whole + 1e-9; at += every) {
      const place = x(at / data.stepSeconds);
      marks.push(h("line", { class: "grid", x1: place, x2: place, y1: TOP - 6, y2: height }), h("text", at ? { x: place, y: 12, "text-anchor": "middle" } : { x: place + 9, y: 12 }, `${Number(at.toFixed(2))}${at ? "" : " s"}`));
    }
    const selected = head ? head.selection : { kind: "none", name: "" };
    draw(svg,
      h("rect", { x: 0, y: 0, width: "100%", height, fill: "transparent", onpointerdown: startScrub }),
      data.lanes.map((lane, at) => h("rect", { class: `lane ${at % 2 ? "" : "alt"} ${selected.kind === "object" && selected.name === lane.name ? "on" : ""}`, x: 0, y: tops[at], width: "100%", height: tall(at), onpointerdown: startScrub, oncontextmenu: (e) => { e.preventDefault(); if (!data.readOnly) openMenu(e, addItems(lane.name, snap(step(e.clientX), e))); } })),
      h("g", { key: "grid" }, marks),
      head && head.loopEnd !== null && head.loopEnd !== undefined ? h("rect", { class: "range", key: "range", x: x((head.loopStart || 0) * data.stepsPerFrame), y: 0, width: Math.max(0, x(head.loopEnd * data.stepsPerFrame) - x((head.loopStart || 0) * data.stepsPerFrame)), height }) : null,
      motion(),
      h("g", { key: "marks" }, data.marks.map((one) => h("path", { class: `mark ${one.ok ? "ok" : "bad"}`, d: `M${x(one.step)} ${TOP - 1}l-4 -7h8z`, style: "cursor:pointer", onclick: () => send({ do: "scrub", frame: frames(one.step) }) }, h("title", {}, `${one.ok ? "Holds" : "Fails"}: ${one.text}`)))),
      h("g", { key: "alarms" }, data.alarms.map((one) => h("path", { class: "alarm", d: `M${x(one.step)} ${TOP + 1}l-4 8h8z` }, h("title", {}, one.text)))),
      h("g", { key: "links" }, data.lanes.flatMap((lane, at) => lane.actions.map((one) => linkOf(one, at)))),
      data.lanes.map((lane, at) => laneOf(lane, at, selected)),
      pace(selected),
      h("g", { class: "playhead", key: "head" }));
    playhead();
  }

  // A band from the first to the last motion that a viewer sees.
  function motion() {
    const moves = data.pace.moves;
    return h("g", { key: "motion", class: "motion", role: "img", "aria-label": moves ? moves.text : "Nothing is seen to move" },
      h("rect", { class: "all", x: x(0), y: 18, width: Math.max(0, x(data.steps) - x(0)), height: 3, rx: 1.5 }),
      moves ? [h("rect", { class: "some", x: x(moves.first), y: 17.5, width: Math.max(3, x(moves.last) - x(moves.first)), height: 4, rx: 2 }), h("rect", { x: x(moves.first), y: 15, width: Math.max(3, x(moves.last) - x(moves.first)), height: 9, fill: "transparent", onpointerdown: startScrub }, h("title", {}, moves.text))] : null);
  }

  // How slow the clip is, beside its frames; a click leads to where that is chosen.
  function pace(selected) {
    const { text, length, pinned } = data.pace;
    const shown = text.length * 5.65 < gutter() - 16 ? text : text.replace("real time", "").trim() || "1 ×";
    const go = () => { send({ do: "select", kind: "clip" }); inspect(); };
    const title = `Shown for ${length}${pinned ? ". Pinned: the planner keeps this pace" : ""}. Click to choose another`;
    return h("g", { key: "pace", class: `pace ${selected.kind === "clip" ? "on" : ""}`, role: "button", tabindex: 0, "aria-label": `Pace: ${text}. ${title}`, onclick: go, onkeydown: (e) => press(e, go) },
      h("title", {}, title),
      h("rect", { class: "under", x: box.scrollLeft, y: 0, width: gutter() - 10, height: TOP - 1 }),
      h("rect", { class: "knob", x: box.scrollLeft + 3, y: 4, width: gutter() - 11, height: TOP - 9, rx: 5 }),
      h("text", { x: box.scrollLeft + 9, y: 19 }, shown));
  }

  const press = (event, act) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    event.stopPropagation();
    act();
  };

  // The picture's border, and the way out of it.
  function leaving(one, y) {
    const at = x(one.step), mid = y + LANE / 2 - 1, border = `M${at} ${y + 1}v${LANE - 4}`;
    const go = () => scrub(one.frame);
    return h("g", { class: one.ok ? "out" : "out bad", key: "leaves", role: "button", tabindex: 0, "aria-label": `${one.text}. Go to frame ${one.frame}`, onclick: go, onkeydown: (e) => press(e, go) },
      h("title", {}, one.text), h("path", { class: "halo", d: border }),
      h("rect", { class: "badge", x: at, y: mid - 7, width: 16, height: 14, rx: 3 }), h("path", { class: "sign", d: `${border}M${at + 4} ${mid}h8M${at + 9} ${mid - 3}l3 3l-3 3` }));
  }

  // From where its cause happened to where a conditional action started.
  function linkOf(one, at) {
    if (!one.when || one.when.step === null || one.when.step === undefined || one.fired === null) return null;
    const from = data.lanes.findIndex((lane) => lane.name === one.when.lane);
    const x0 = x(one.when.step), y0 = tops[from < 0 ? at : from] + LANE / 2, x1 = x(one.fired), y1 = tops[at] + rowOf(one.id) + LANE / 2;
    const bend = Math.max(10, (x1 - x0) / 2);
    return h("g", { "data-link": one.id },
      h("path", { class: "link-line", d: `M${x0} ${y0}C${x0 + bend} ${y0} ${x1 - bend} ${y1} ${x1} ${y1}` }),
      h("circle", { class: "link-end", cx: x0, cy: y0, r: 3.5 }, h("title", {}, `${one.label} starts ${one.when.text}`)));
  }

  function laneOf(lane, at, selected) {
    const y = tops[at], beside = besides(lane);
    return h("g", { "data-lane": lane.name, key: `lane ${lane.name}` },
      h("g", { key: "contacts" }, lane.contacts.map((one) => h("circle", { class: "contact", cx: x(one.step), cy: y + tall(at) - 3, r: 2 }, h("title", {}, `Touches ${one.with.replaceAll("_", " ")} at ${seconds(one.step)}`)))),
      lane.actions.map((one) => actionOf(one, y + rowOf(one.id), selected, beside)),
      lane.leaves ? leaving(lane.leaves, y) : null,
      h("rect", { x: box.scrollLeft, y, width: gutter() - 4, height: tall(at), fill: "var(--panel)" }),
      h("rect", { class: "tint", x: box.scrollLeft + 8, y: y + 8.500, width: 9, height: 9, rx: 2, fill: `rgb(${lane.colour.join(" ")})` }),
      h("text", { class: "name", x: box.scrollLeft + 22, y: y + 17, onclick: () => send({ do: "select", kind: "object", name: lane.name }) }, fit(lane.name.replaceAll("_", " ")), h("title", {}, lane.name.replaceAll("_", " "))));
  }

  const shortened = (text, room) => { const most = Math.floor(room / 6.6); return text.length <= most ? text : most < 4 ? "" : `${text.slice(0, most - 1)}…`; };
  const fit = (name) => shortened(name, gutter() - 26);

  // Pixels up to the next bar of the row, for the words beside one that is too short for them.
  function roomAfter(one, right, lane) {
    const next = lane.actions.filter((other) => rowOf(other.id) === rowOf(one.id) && other.start > one.start).map((other) => other.start);
    return (next.length ? x(Math.min(...next)) : gutter() + width() + 18) - right;
  }

  // Words beside short bars: where those of one do not fit, one text behind the next says both: "2 × Push".
  const verb = (one) => one.label.replace(/( to)? [−\d].*$/, "");
  const counted = (crowd) => crowd.reduce((told, one) => (told.at(-1)?.text === verb(one) ? (told.at(-1).many++, told) : [...told, { text: verb(one), many: 1 }]), []).map(({ text, many }) => (many > 1 ? `${many} × ${text}` : text)).join(", ");
  const ends = (one) => (one.instant ? x(one.start) + 12 : x(one.start + one.duration) + 5);
  // Where words may stand beside a bar, and how wide: up to the mark of where the thing leaves the picture, or past it.
  function placeAfter(one, text, lane) {
    const from = ends(one), room = roomAfter(one, from, lane), out = lane.leaves && rowOf(one.id) === 0 ? x(lane.leaves.step) : null;
    if (out === null || out + MARK <= from || out >= from + room) return { from, room };
    const before = { from, room: out - from - 4 }, past = { from: out + MARK, room: room - (out + MARK - from) };
    return before.room >= Math.min(6.6 * text.length, past.room) ? before : past;
  }
  const inside = (one) => !one.instant && x(one.start + one.duration) - x(one.start) > 6.6 * one.label.length + 12;
  function besides(lane) {
    const found = new Map();
    for (const level of new Set(lane.actions.map((one) => rowOf(one.id)))) {
      let crowd = [];
      const row = lane.actions.filter((one) => rowOf(one.id) === level).sort((a, b) => a.start - b.start);
      for (const [at, one] of row.entries()) {
        if (inside(one)) { crowd = []; continue; }
        crowd.push(one);
        const text = crowd.length > 1 ? counted(crowd) : one.label, { from, room } = placeAfter(one, text, lane);
        if (6.6 * text.length > room && row[at + 1] && !inside(row[at + 1])) continue;
        found.set(one.id, { text: shortened(text, room), from });
        crowd = [];
      }
    }
    return found;
  }

  function actionOf(one, y, selected, beside) {
    const mine = drag && drag.id === one.id ? drag : one;
    const left = x(mine.start), right = x(mine.start + mine.duration), color = COLORS[one.kind] || "#888";
    const on = selected.kind === "action" && selected.name === one.id;
    const title = `${one.label} · ${one.when ? one.when.text : `from ${seconds(one.start)}`}${one.instant ? "" : ` for ${seconds(one.duration)}`}${one.never ? " · never started" : ""}`;
    const body = one.instant
      ? h("path", { class: "body", d: `M${left} ${y + 4}l8 8.500l-8 8.500l-8 -8.500z`, fill: color })
      : h("rect", { class: "body", x: left, y: y + 3, width: Math.max(7, right - left), height: LANE - 7, rx: 4, fill: color });
    const text = inside(mine === one ? one : { ...one, ...mine }) ? h("text", { x: left + 7, y: y + 16 }, one.label)
      : h("text", { x: mine === one && beside.has(one.id) ? beside.get(one.id).from : ends(mine === one ? one : { ...one, ...mine }), y: y + (one.instant ? 17 : 16), style: "fill:var(--text)" }, beside.get(one.id)?.text || "");
    return h("g", { key: one.id, class: `act ${on ? "on" : ""} ${one.muted ? "muted" : ""} ${one.never ? "never" : ""}`, "data-action": one.id, "data-start": mine.start, "data-duration": mine.duration,
      tabindex: 0, role: "button", "aria-label": title, onpointerdown: (e) => startDrag(e, one, "move"), onkeydown: (e) => keys(e, one),
      oncontextmenu: (e) => { e.preventDefault(); openMenu(e, actionItems(one)); } },
      h("title", {}, title),
      body, text,
      one.when ? h("text", { x: left - 12, y: y + 16, style: "fill:var(--muted)" }, "⚡") : null,
      one.instant ? null : [
        h("rect", { class: "edge", "data-edge": "start", x: left - 3, y, width: 7, height: LANE, onpointerdown: (e) => startDrag(e, one, "start") }),
        h("rect", { class: "edge", "data-edge": "end", x: Math.max(left + 4, right - 4), y, width: 8, height: LANE, onpointerdown: (e) => startDrag(e, one, "end") })]);
  }

  function playhead() {
    const group = svg.querySelector(".playhead");
    if (!group || !head || !data) return;
    const at = x(drag && drag.what === "head" ? drag.step : head.step), height = svg.getAttribute("height");
    draw(group,
      h("line", { class: "head-line", x1: at, x2: at, y1: 0, y2: height, "pointer-events": "none" }),
      h("path", { class: "head-grip", d: `M${at - 6} 0h12v8l-6 6l-6 -6z`, onpointerdown: startScrub }),
      tip ? [h("rect", { class: "tip-box", x: tip.x, y: tip.y, width: tip.text.length * 6.3 + 14, height: 20, rx: 5 }), h("text", { class: "tip", x: tip.x + 7, y: tip.y + 14 }, tip.text)] : null);
  }

  // --- dragging -------------------------------------------------------------------------------

  function startScrub(event) {
    if (event.button !== 0) return;
    closeMenu();
    svg.setPointerCapture(event.pointerId);
    drag = { what: "head", step: step(event.clientX), sent: -1 };
    moveScrub(event);
    if (head && head.playing) send({ do: "play", on: false });
  }

  function moveScrub(event) {
    drag.step = step(event.clientX);
    const frame = frames(drag.step);
    if (frame !== drag.sent) {
      drag.sent = frame;
      send({ do: "scrub", frame });
    }
    playhead();
  }

  function startDrag(event, one, what) {
    if (event.button !== 0) return;
    event.stopPropagation();
    closeMenu();
    send({ do: "select", kind: "action", name: one.id });
    inspect();
    event.currentTarget.closest(".act").focus({ preventScroll: true });
    if (data.readOnly || (one.when && (what === "start" || one.never))) return;
    svg.setPointerCapture(event.pointerId);
    drag = { what, id: one.id, start: one.start, duration: one.duration, from: step(event.clientX), one, moved: false };
  }

  svg.onpointermove = (event) => {
    // What was dropped and waits for its answer no longer follows the pointer.
    if (!drag || drag.what === "waiting") return;
    if (drag.what === "head") return moveScrub(event);
    const by = step(event.clientX) - drag.from, one = drag.one;
    if (by) drag.moved = true;
    // What waits for something can start no earlier than that.
    const first = one.when ? one.start - one.when.delay : 0;
    if (drag.what === "move") drag.start = Math.max(first, Math.min(data.steps - (one.instant ? 1 : one.duration), snap(one.start + by, event)));
    if (drag.what === "end") drag.duration = Math.max(1, Math.min(data.steps - one.start, snap(one.start + one.duration + by, event) - one.start));
    if (drag.what === "start") {
      drag.start = Math.max(0, Math.min(one.start + one.duration - 1, snap(one.start + by, event)));
      drag.duration = one.start + one.duration - drag.start;
    }
    attempt(editsOf(one, drag.start, drag.duration));
    readout();
    lanes();
  };

  // Where the bar is now, and what would come of dropping it here.
  function readout() {
    const words = drag.what === "move" ? `${seconds(drag.start)} · frame ${frames(drag.start)}` : `lasts ${seconds(drag.duration)}`;
    const tried = drag.moved ? value("attempt") : null;
    const outcome = tried && tried.problem ? " · not possible" : tried && tried.of ? ` · ${tried.holds} of ${tried.of} hold` : "";
    const text = words + outcome;
    tip = { x: Math.max(box.scrollLeft + 2, Math.min(x(drag.start) + 8, box.clientWidth - text.length * 6.3 - 20 + box.scrollLeft)), y: 1, text };
  }

  svg.onpointerup = () => {
    const done = drag;
    if (!done || done.what === "waiting") return;
    tip = null;
    if (done.what === "head" || !done.moved) { drag = null; endAttempt(); lanes(); return; }
    retime(done.one, done.start, done.duration);
  };
  const letGo = () => { drag = null; tip = null; endAttempt(); lanes(); };
  svg.onpointercancel = letGo;
  addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !drag || !drag.one) return;
    event.preventDefault();
    event.stopPropagation();
    letGo();
  }, true);

  // One list of edits is validated as a whole, so their order does not matter.
  function editsOf(one, start, duration) {
    const edits = [];
    const path = `event.actions.${one.id}`;
    if (start !== one.start && one.when) edits.push({ op: "set", path: `${path}.when.delay`, value: Math.max(0, one.when.delay + start - one.start) });
    else if (start !== one.start) edits.push({ op: "set", path: `${path}.start_step`, value: start });
    if (duration !== one.duration && !one.instant) edits.push({ op: "set", path: `${path}.duration`, value: duration });
    return edits.length ? edits : null;
  }

  // The bar stays where it was dropped until the server has answered; a refusal brings it back.
  function retime(one, start, duration) {
    const edits = editsOf(one, start, duration);
    if (!edits) { drag = null; endAttempt(); lanes(); return; }
    dropAttempt();
    const mine = { id: one.id, start, duration, what: "waiting" };
    drag = mine;
    const back = () => { if (drag === mine) { drag = null; lanes(); } };
    if (!edit(edits, "timeline", back)) back();
    else setTimeout(back, 5000);
    lanes();
  }

  // What was dropped is drawn until the server has the same, or says no. What is still under the
  // pointer may have been changed meanwhile, or be gone.
  function settle() {
    if (!drag || !drag.id) return;
    const now = data.lanes.flatMap((lane) => lane.actions).find((one) => one.id === drag.id);
    if (drag.what === "waiting") {
      if (!now || (now.start === drag.start && now.duration === drag.duration)) drag = null;
    } else if (!now || data.readOnly) {
      [drag, tip] = [null, null];
      endAttempt();
    } else drag.one = now;
  }

  function keys(event, drawn) {
    // Presses faster than the server's answers add up.
    const one = drag && drag.what === "waiting" && drag.id === drawn.id ? { ...drawn, start: drag.start, duration: drag.duration } : drawn;
    const unit = event.shiftKey ? data.stepsPerFrame * 5 : data.stepsPerFrame;
    const move = { ArrowLeft: -unit, ArrowRight: unit }[event.key];
    if (move && event.ctrlKey && !one.instant) retime(one, one.start, Math.max(1, Math.min(data.steps - one.start, one.duration + move)));
    else if (move) retime(one, Math.max(one.when ? one.start - one.when.delay : 0, Math.min(data.steps - (one.instant ? 1 : one.duration), one.start + move)), one.duration);
    else if (event.key === "Delete" || event.key === "Backspace") remove(one);
    else if (event.key === "Enter") send({ do: "select", kind: "action", name: one.id });
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  // Zooming keeps what is under the pointer, or the playhead, where it is.
  function zoomBy(factor, clientX) {
    if (!data) return;
    const edge = box.getBoundingClientRect().left;
    const at = clientX === undefined ? (head ? head.step : 0) : step(clientX);
    const held = clientX === undefined ? x(at) - box.scrollLeft : clientX - edge;
    zoom = Math.max(1, Math.min(16, zoom * factor));
    lanes();
    box.scrollLeft = x(at) - held;
    transport();
  }
  box.onwheel = (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoomBy(event.deltaY < 0 ? 1.2 : 1 / 1.2, event.clientX);
  };
  box.onkeydown = (event) => {
    const factor = { "+": 1.5, "=": 1.5, "-": 1 / 1.5 }[event.key];
    if (!factor || event.ctrlKey) return;
    event.preventDefault();
    zoomBy(factor);
  };
  new ResizeObserver(() => lanes()).observe(box);
  // Names stay where they are while what they name goes by.
  let seen = 0;
  box.onscroll = () => { if (box.scrollLeft !== seen) { seen = box.scrollLeft; lanes(); } };

  on("timeline", (next) => {
    data = next;
    settle();
    stack();
    transport();
    lanes();
  });
  on("attempt", () => {
    if (!drag || !drag.one || !tip) return;
    readout();
    playhead();
  });
  on("playhead", (next) => {
    const reselect = !head || head.selection.name !== next.selection.name || head.selection.kind !== next.selection.kind || head.loopEnd !== next.loopEnd || head.loopStart !== next.loopStart;
    head = next;
    transport();
    if (reselect) lanes();
    else playhead();
  });
}
