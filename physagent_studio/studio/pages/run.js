// Run: which session, what is happening, what comes next.

import { button, draw, h, iconButton, say, SECOND_CLICK } from "./dom.js";
import { openPopup } from "./popup.js";
import { on, send } from "./wire.js";

const ROLES = [
  ["generator", "First program", "You write the first program; the scene and the demands are laid out for it"],
  ["verifier", "Verdicts", "You say whether each stage holds; what was measured is shown beside"],
  ["planner", "Repairs", "After a failure you change the program yourself"],
];
const LOOKS = [["With motion blur", { shutter: 0.5 }], ...["832x480", "480x832", "720x480", "1280x720"].map((size) => [size.replace("x", " × "), { size }]), ["832 × 480, all of the picture", { size: "832x480", way: "letterbox" }]];
const POLICIES = [["ask", "I decide"], ["ask_when", "Ask me when unsure"], ["auto", "Decide by itself"]];

export function startRun(host, dialogs, more) {
  let last = null;
  let saving = null; // a file that was asked for: its kind, and what was there of it before
  let unfolded = false; // the roles
  let since = 0; // when the work that is going on began
  // The clock of what is going on; one text, so that nothing else is touched.
  setInterval(() => {
    const clock = host.querySelector("[data-clock]");
    if (clock) clock.textContent = passed(since);
  }, 1000);

  // What was asked for is brought as a download once it is made.
  const save = (kind, intent) => {
    const made = last.outputs.find((one) => one.kind === kind);
    saving = { kind, session: last.session, seen: made?.made };
    send(intent);
  };
  function arrive(run) {
    if (!saving || run.busy) return;
    const made = run.session === saving.session ? run.outputs.find((one) => one.kind === saving.kind && one.made !== saving.seen) : null;
    if (run.session === saving.session && !made) return;
    saving = null;
    if (made) h("a", { href: made.url, download: made.url.split("/").pop() }).click();
  }

  const show = (run) => {
    arrive(run);
    if (run.busy && !(last && last.busy)) since = Date.now();
    // What lies below stays where it is while something runs: nobody clicks beside it.
    host.style.minHeight = !run.busy ? "" : host.style.minHeight || `${host.offsetHeight}px`;
    last = run;
    const waiting = run.phase === "decide" && !run.draft;
    const mine = Boolean(run.turn) && !run.draft;
    const over = run.phase === "done" && !run.draft;
    draw(host,
      h("div", { class: "row run-head" },
        h("div", { class: "title grow clip", title: run.title }, run.title || "PhysAgent Studio"),
        iconButton("undo", "Undo (Ctrl+Z)", () => send({ do: "undo" }), { disabled: !run.canUndo }),
        iconButton("redo", "Redo (Ctrl+Shift+Z)", () => send({ do: "undo", forward: true }), { disabled: !run.canRedo }),
        h("button", { class: "b small", type: "button", title: "Examples, your sessions, a new photo (O)", onclick: dialogs.open }, "Open…"),
        iconButton("more", "More: look, presenting, tour, keys", (e) => openPopup(e.currentTarget, more(), "More"), { "aria-haspopup": "menu" })),
      run.prompt ? h("p", { class: "prompt" }, h("q", {}, run.prompt)) : h("p", { class: "prompt" }, run.session ? "No sentence yet." : "See a photo happen: open an example, bring a photo of your own, or build in an empty scene."),
      run.busy ? busy(run, since) : null,
      !run.busy && !run.session ? h("div", { class: "stack" },
        button("Open an example or a session", dialogs.open, { class: "b main" }),
        h("div", { class: "row" }, button("New from a photo", dialogs.fresh, { class: "b wide" }), button("An empty scene", () => send({ do: "bare" }), { class: "b wide" }))) : null,
      run.busy || !run.session ? null : h("div", { class: "stack" },
        state(run),
        over && run.realised ? taken(run, save) : h("div", { class: "row wrap" },
          button(corrected(run) ? "Start" : run.draft ? "Run my edits" : over ? "Go on" : run.started ? "Next step" : "Start", () => send({ do: "step" }),
            { class: waiting || mine || over ? "b wide" : "b main wide", disabled: waiting || mine || run.readOnly, title: waiting ? "First decide on the proposal, at the lower left" : mine ? "It is your turn" : run.readOnly ? "An earlier round is open; go back to the current one" : "Goes on until a decision is needed (R)" }),
          button("Run to the end", () => send({ do: "step", all: true }), { class: "b wide", disabled: mine || run.readOnly, title: "Decides by itself, round after round" }))),
      run.session ? h("div", { class: "row wrap", style: "margin-top:10px" },
        h("label", { class: "row", style: "flex:1 1 82px" },
          h("select", { value: run.policy, "aria-label": "Who decides", title: "Who decides on proposals", onchange: (e) => send({ do: "policy", policy: e.target.value }) },
            POLICIES.map(([key, text]) => h("option", { value: key }, text)))),
        h("label", { class: "row", style: "gap:5px" }, h("span", { class: "muted" }, "Rounds"),
          h("span", { class: "num" }, `${run.used} of`),
          h("input", { type: "number", min: 1, max: 100, value: run.budget, "aria-label": "Most rounds", style: "width:46px;padding-inline:6px 2px",
            onchange: (e) => send({ do: "budget", rounds: Number(e.target.value) }) }))) : null,
      run.session ? roles(run, unfolded, () => { unfolded = !unfolded; show(run); }) : null,
      run.session ? meters(run) : null);
    document.title = run.title ? `${run.title} · PhysAgent Studio` : "PhysAgent Studio";
  };
  on("run", show);
  return { save };
}

// Which roles the person plays; the agent plays the others.
function roles(run, unfolded, unfold) {
  const chosen = (role) => run.byHand.includes(role);
  const own = ROLES.filter(([role]) => chosen(role)).map(([, text]) => text.toLowerCase());
  const mine = run.policy === "auto" ? own : ["decisions", ...own];
  return h("div", { class: "roles" },
    h("button", { class: "link", type: "button", "aria-expanded": String(unfolded), onclick: unfold, title: "Roles that you take over for good: the program waits for you there" }, `Done by me: ${mine.join(", ") || "nothing"}`),
    unfolded ? h("div", { class: "row wrap", role: "group", "aria-label": "What is done by me" },
      ROLES.map(([role, text, title]) => h("button", { class: "b small", key: role, type: "button", title: role === "generator" && run.started ? "The first program has run already" : title,
        disabled: role === "generator" && run.started && !chosen(role), "aria-pressed": String(chosen(role)), onclick: () => send({ do: "role", role, on: !chosen(role) }) }, text))) : null);
}

const passed = (since) => { const seconds = Math.floor((Date.now() - since) / 1000); return seconds < 2 ? "" : `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`; };

// What has been reached can be taken away.
const taken = (run, save) => h("div", { class: "stack", style: "gap:4px" },
  h("div", { class: "row" },
    button("Save the video", () => save("video", { do: "video" }), { class: "b wide", title: `The clip as an MP4, over the photo: ${run.clip}` }),
    iconButton("more", "Save it in another size, or with motion blur", (e) => openPopup(e.currentTarget, LOOKS.map(([text, look]) => [text, "", () => save("video", { do: "video", ...look })]), "Sizes of the video"), { "aria-haspopup": "menu" }),
    button("Save a replay", () => save("replay", { do: "export", kind: "html" }), { class: "b wide", title: "All rounds and the scene in one HTML file" })),
  h("p", { class: "faint num hide-narrow", style: "font-size:12px" }, run.clip));

// What it has cost so far, and what was made of the round on view.
function meters(run) {
  const { time, waited, rows } = run.spending;
  const parts = [say(run.simulations, "simulation"), `${time} of work`, waited ? `${waited} of it the model's` : ""];
  return h("div", { class: "meters" },
    run.outputs.length ? h("div", { class: "row wrap outputs" }, run.outputs.map((one) => h("a", { class: "chip accent", key: one.url, href: one.url, title: one.kind === "video" ? run.clip : null, ...(one.save ? { download: "" } : { target: "_blank", rel: "noopener" }) }, { video: "Video of this round", replay: "Replay (HTML)", recording: "Recording (.viser)" }[one.kind]))) : null,
    rows.map((one) => h("div", { class: "meter", key: one.name, title: one.most ? `${one.used} of ${one.most}` : one.used },
      h("span", { class: "muted" }, one.name), h("span", { class: "bar" }, h("i", { class: one.share > 0.8 ? "near" : "", style: `width:${(one.share || 0) * 100}%` })), h("span", { class: "num" }, one.most ? `${one.used} of ${one.most}` : one.used))),
    run.simulations ? h("p", { class: "faint num" }, parts.filter(Boolean).join(" · ")) : null);
}

function busy(run, since) {
  // What has not begun to count yet is shown as going on, not as standing still.
  const known = Boolean(run.progress);
  return h("div", { class: "stack" },
    h("div", { role: "status" }, sentence(run.busy)),
    h("div", { class: "row" },
      h("div", { class: known ? "bar grow" : "bar unknown grow" }, h("i", { style: known ? `width:${run.progress * 100}%` : "" })),
      known ? h("span", { class: "muted num", style: "white-space:nowrap" }, `${Math.round(run.progress * 100)} %`) : null,
      h("span", { class: "faint num", "data-clock": true, "aria-hidden": "true" }, passed(since)),
      // The second of two clicks on what began it would end it at once.
      button("Cancel", () => Date.now() - since > SECOND_CLICK && send({ do: "cancel" }), { class: "b small" })));
}

// What was corrected before the first run belongs to it: nothing of it has to be run by itself.
const corrected = (run) => run.draft && !run.started && run.rounds > 0;

const sentence = (text) => text.charAt(0).toUpperCase() + text.slice(1) + "…";

function state(run) {
  if (run.readOnly) return h("div", { class: "strip warn" }, "An earlier round is open, read-only.");
  if (corrected(run)) return h("div", { class: "row strip" }, h("span", { class: "grow" }, "What you corrected is in. Start runs the event with it."), h("button", { class: "link", type: "button", onclick: () => send({ do: "discard" }) }, "Discard"));
  if (run.draft) return h("div", { class: "row strip warn" }, h("span", { class: "grow" }, "You have edits that no round has run yet."), h("button", { class: "link", type: "button", onclick: () => send({ do: "discard" }) }, "Discard"));
  if (run.phase === "done") return h("div", { class: run.realised && !run.inDoubt ? "strip ok" : "strip warn" }, run.outcome);
  return h("div", { class: "muted" }, sentence(run.doing).replace("…", "."));
}
