// The line to the server: newest values in, intents out. A lost line is taken up again.

const values = {};
const listeners = new Map();
let socket = null;
let pause = 300;
let ticket = 0;
const answers = new Map();
export const viewerToken = Array.from(crypto.getRandomValues(new Uint8Array(12)), (b) => b.toString(16).padStart(2, "0")).join("");

export const value = (channel) => values[channel];

export function on(channel, listener) {
  if (!listeners.has(channel)) listeners.set(channel, new Set());
  listeners.get(channel).add(listener);
  if (channel in values) listener(values[channel]);
}

function emit(channel, data) {
  for (const listener of listeners.get(channel) || []) listener(data);
}

// While it presents, a page only looks; the server refuses the rest as well.
const LOOKING = new Set(["play", "scrub", "speed", "loop", "select", "show", "look", "bookmark", "viewer", "compare", "round", "dismiss", "list_sessions", "present", "measure", "hide"]);
let presents = false;
export const presenting = () => presents;

export function present(wanted) {
  presents = wanted;
  send({ do: "present", on: wanted });
}

function refuse(intent) {
  const text = "Presenting: nothing is changed here. Escape ends it.";
  const refused = answers.get(intent.ticket);
  answers.delete(intent.ticket);
  if (intent.do !== "try") emit("say", { level: "info", text });
  if (refused) refused(text);
  return false;
}

// What is selected here: what this page has asked for, from the moment that it asks.
let asked = null;
export const selected = () => asked || values.playhead?.selection || { kind: "none", name: "" };

function select(wish) {
  const before = selected();
  asked = wish;
  tell(before);
}

function tell(before) {
  const now = selected();
  if (now.kind === before.kind && now.name === before.name) return;
  values.selection = now;
  emit("selection", now);
}

// The server has come so far, or never will.
function confirm(before, given) {
  if (!asked || given === null || (given.kind === asked.kind && given.name === asked.name)) asked = null;
  tell(before);
}

export function send(intent) {
  if (presents && !LOOKING.has(intent.do)) return refuse(intent);
  if (socket && socket.readyState === WebSocket.OPEN) {
    const letter = "version" in values ? { ...intent, seen: values.version } : intent;
    socket.send(JSON.stringify(letter, (_key, one) => (typeof one === "number" && !Number.isFinite(one) ? String(one) : one)));
    if (intent.do === "select") select({ kind: intent.kind, name: intent.name || "" });
    return true;
  }
  emit("say", { level: "warning", text: "Not connected; this was not sent." });
  return false;
}

// An edit that is already drawn: `refused` is called with the reason when the server says no.
function ask(intent, refused) {
  ticket += 1;
  if (refused) answers.set(ticket, refused);
  return send({ ...intent, ticket });
}

export const edit = (edits, reason, refused) => ask({ do: "edit", edits, reason: reason || "" }, refused);

// Another pace of the clip, pinned.
export const retime = (factor, refused) => ask({ do: "retime", factor }, refused);

export const setField = (path, data, refused) => edit([{ op: "set", path, value: data }], "", refused);

// What an edit that is still under the pointer would make: at most one is sent every 50 ms, and
// the newest always is. `null` ends it.
const PAUSE = 50;
let newest, resting = 0, tried = "null";

// What is tried may also be an intent that the server makes edits of.
export function attempt(edits) {
  newest = edits;
  if (!resting) sendAttempt();
}

function sendAttempt() {
  const text = JSON.stringify(newest);
  if (text === tried) return;
  tried = text;
  send(newest?.do ? newest : { do: "try", edits: newest });
  resting = setTimeout(() => { resting = 0; sendAttempt(); }, PAUSE);
}

// A drop says the same as the last attempt and ends it by itself.
export function dropAttempt() {
  clearTimeout(resting);
  resting = 0;
  tried = "null";
}

export function endAttempt() {
  const open = tried !== "null" || resting;
  dropAttempt();
  if (open) send({ do: "try", edits: null });
}

// The frame that was asked for last; key presses faster than the answers add up. `early` was asked
// for before the page was told of a clip, and is gone to as soon as it is.
let wanted = null, early = null;

export function scrub(frame) {
  const head = values.playhead;
  if (!head) return void (early = frame);
  wanted = Math.max(0, Math.min(head.frames - 1, frame));
  send({ do: "scrub", frame: wanted });
}

export const scrubBy = (by) => scrub((wanted ?? values.playhead?.frame ?? early ?? 0) + by);

export function connect() {
  socket = new WebSocket(new URL("socket", document.baseURI).href.replace(/^http/, "ws"));
  socket.onopen = () => {
    pause = 300;
    send({ do: "viewer", token: viewerToken });
    if (presents) send({ do: "present", on: true });
    emit("line", true);
  };
  socket.onmessage = (event) => {
    const { on: channel, is: data } = JSON.parse(event.data);
    if (channel === "answer") {
      const refused = answers.get(data.ticket);
      answers.delete(data.ticket);
      if (refused && data.problem) refused(data.problem);
      return;
    }
    const before = selected();
    if (channel !== "say") values[channel] = data;
    if (channel === "playhead" && (data.playing || data.frame === wanted)) wanted = null;
    emit(channel, data);
    if (channel === "playhead" && early !== null) {
      scrub(early);
      early = null;
    }
    if (channel === "playhead") confirm(before, data.selection);
    else if (channel === "say" && data.level === "error") confirm(before, null);
  };
  socket.onclose = () => {
    confirm(selected(), null);
    emit("line", false);
    setTimeout(connect, pause);
    pause = Math.min(pause * 1.6, 4000);
  };
}
