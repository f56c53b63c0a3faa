// Checklist: what the sentence demands, what physics does and what a viewer sees, with what was
// measured for it, and a new demand by hand.

import { button, h, say } from "./dom.js";
import { moment } from "./time.js";
import { edit, scrub, send } from "./wire.js";

const STATEMENTS = [
  ["moves", "moves", { distance: 0.1 }], ["touches", "contacts", { other: 1 }], ["falls over", "topples", {}], ["stays", "stays", {}], ["falls", "falls", {}],
  ["ends on", "rests_on", { other: 1 }], ["stops", "stops", {}], ["leaves", "leaves", { other: 1 }], ["turns", "rotates", {}],
];
// What a viewer must see is no statement of its own: it is said of the contract as a whole.
const SEEN = [["stays in the picture", "in"], ["leaves the picture", "out"], ["is never faster than 1 m/s", "slow"]];

export function makeChecklist(show, focus) {
  let data = null;
  let unfolded = false;
  const opened = new Set(); // groups that show what holds as well, and demands whose parts are not shown as they would be
  const folds = () => data.proposal || data.checks.some((c) => c.seen);
  let adding = false;
  // What is chosen is kept here: the page may be drawn anew between two choices.
  let wanted = { who: "", does: "", with: "" };

  const toggle = () => { adding = !adding; wanted = { who: "", does: "", with: "" }; show(); focus(); };

  const told = (text) => dispatchEvent(new CustomEvent("told", { detail: text }));
  const set = (path, next) => edit([{ op: "set", path: `contract.${path}`, value: next }], "demanded by hand");

  // A demand on what a viewer sees; whether it was one.
  function seen(subject, kind) {
    const name = subject.replaceAll("_", " "), { leaving, paces } = data.names;
    if (kind === "slow") set("paces", [...paces.filter((one) => one.subject !== subject), { subject, verb: "goes", low: 0, high: 1 }]);
    else if (kind === "out") set("leaving", [...new Set([...leaving, subject])]);
    else if (kind === "in" && leaving.includes(subject)) set("leaving", leaving.filter((one) => one !== subject));
    else if (kind === "in") told(`It is looked after already that ${name} stays in the picture, as soon as it moves.`);
    return SEEN.some((one) => one[1] === kind);
  }

  // A new line of the checklist: who does what.
  function demand() {
    const names = data.names;
    if (!names.objects.length || data.readOnly) return null;
    if (!adding) return h("button", { class: "link", type: "button", onclick: toggle }, "+ Demand something");
    const first = { who: names.objects[0], does: STATEMENTS[0][1], with: names.places[0] };
    const chosen = (part, known) => known.includes(wanted[part]) ? wanted[part] : first[part];
    const pick = (list, label, part) => {
      const values = list.map((one) => Array.isArray(one) ? one[1] : one), words = (one) => Array.isArray(one) ? one[0] : one.replaceAll("_", " ");
      return h("select", { "aria-label": label, onchange: (e) => { wanted = { ...wanted, [part]: e.target.value }; show(); } }, list.map((one, i) => h("option", { value: values[i], selected: values[i] === chosen(part, values) }, words(one))));
    };
    const add = () => {
      const subject = chosen("who", names.objects), kind = wanted.does || first.does, other = chosen("with", names.places);
      if (seen(subject, kind)) return toggle();
      if (kind === "topples" && names.round.includes(subject)) return told(`A round thing cannot fall over; demand that ${subject.replaceAll("_", " ")} moves, stops or falls.`);
      if (other === subject && STATEMENTS.find((one) => one[1] === kind)[2].other) return told("A thing cannot do that with itself; choose another one.");
      const more = STATEMENTS.find((one) => one[1] === kind)[2];
      const item = { id: `${subject}_${kind}_${names.statements.length + 1}`, kind, subject, ...more };
      if (more.other) item.other = other;
      edit([{ op: "add", path: "contract.statements", item }], "demanded by hand");
      toggle();
    };
    return h("div", { class: "card stack", style: "margin-top:6px", key: "demand" }, h("div", { class: "row wrap" }, pick(names.objects, "Who", "who"), pick([...STATEMENTS, ...SEEN], "Does what", "does"), pick(names.places, "With what", "with")), button("Add to the checklist", add, { class: "b wide" }));
  }

  function checklist() {
    if (!data.checks.length) return data.names ? demand() : null;
    const contract = data.checks.filter((c) => c.group === "demand" && !c.folded);
    // While there is something to decide, what holds is folded away, so that the proposal is near;
    // so is what holds in the reconstruction, which is not what the sentence speaks of.
    const holds = contract.filter((c) => c.ok || (c.seen && c.part));
    const counted = contract.filter((c) => !c.part), held = counted.filter((c) => c.ok).length;
    const fold = Boolean(folds()) && !unfolded && holds.length > 0;
    const seen = contract.some((c) => c.seen), what = seen ? "check" : "demand";
    const asked = () => [
      contract.length ? heading(seen ? "The scene against the photo" : "What the sentence demands", held, counted.length) : null,
      h("div", { role: "list", "aria-label": seen ? "Checklist of the scene" : "Checklist of what is demanded" }, (fold ? contract.filter((c) => !holds.includes(c)) : contract).map(check)),
      folds() && holds.length ? h("p", { style: "padding:4px" }, h("button", { class: "link", type: "button", onclick: () => { unfolded = !unfolded; show(); } }, fold ? `${say(held, what)} ${held === 1 ? "holds" : "hold"}: show` : "Show only what fails")) : null,
      fold ? null : demand()];
    const parts = [["demand", asked], ["view", () => group("view", "What a viewer sees")], ["physics", () => group("physics", "Physics")]];
    // What fails comes first and is never folded away.
    const fails = ([key]) => data.checks.some((c) => c.group === key && !c.ok && !c.part);
    return h("div", { class: "section" }, h("div", { class: "head" }, "Checklist"), [...parts.filter(fails), ...parts.filter((one) => !fails(one))].map(([, part]) => part()));
  }

  const heading = (text, held, of) => h("div", { class: "group" }, h("span", {}, text), h("span", { class: `push num${held < of ? " bad" : ""}`, title: "hold" }, `${held} of ${of}`));

  function group(key, text) {
    const all = data.checks.filter((c) => c.group === key);
    if (!all.length) return null;
    const broken = all.filter((c) => !c.ok), whole = opened.has(key);
    const toggle = () => { if (whole) opened.delete(key); else opened.add(key); show(); };
    const count = all.length - broken.length;
    return h("div", { key: `group-${key}` },
      heading(text, count, all.length),
      h("div", { role: "list", "aria-label": text }, (whole ? [...broken, ...all.filter((c) => c.ok)] : broken).map(check)),
      count ? h("p", { style: "padding:0 4px" }, h("button", { class: "link", type: "button", "aria-expanded": String(whole), onclick: toggle }, whole ? (broken.length ? "Show only what fails" : "Hide") : `${say(count, "check")} ${count === 1 ? "holds" : "hold"}: show`)) : null);
  }

  function check(c, at, all) {
    const jump = !c.frame ? null : h("button", { class: "link num", type: "button", title: "Show this moment", onclick: () => scrub(c.frame) }, moment(c.frame));
    const first = c.clause && !c.folded && (!at || all[at - 1].clause !== c.clause);
    return [first ? h("div", { class: "clause", key: `clause-${c.id}` }, `“${c.clause}”`) : null,
      h("div", { class: c.part ? "check part" : "check", role: "listitem", key: c.id, title: !c.part ? "" : c.seen ? "Measured, but it decides nothing by itself" : "Serves another demand and is not counted by itself" },
        h("span", { class: `dot ${c.ok ? "ok" : c.part ? "" : "bad"}`, title: c.ok ? "holds" : "does not hold" }, c.ok ? "✓" : c.part ? "–" : "✕"),
        c.always ? h("span", { title: c.found }, c.text) : h("button", { class: "plain", type: "button", title: c.found || "Change what is demanded", onclick: () => send({ do: "select", kind: "statement", name: c.id }) }, c.text),
        c.also?.length ? h("span", { class: "fig" }, "also for ", c.also.map((one) => `“${one}”`).join(", ")) : null,
        h("span", { class: "fig num" },
          c.measured ? h("span", {}, c.measured) : null, jump,
          c.predicted && c.predicted.ok !== c.ok ? h("span", { class: c.predicted.ok ? "chip ok" : "chip bad", title: c.predicted.measured }, `${data.proposal?.gentler ? "more gently" : "with the repair"}: ${c.predicted.ok ? "holds" : "fails"}`) : null),
        c.parts?.length ? parts(c) : null)];
  }

  // What a demand is made of, folded under it; where it fails, it is open.
  function parts(c) {
    const all = data.checks.filter((one) => c.parts.includes(one.id)), held = all.filter((one) => one.ok).length;
    const whole = opened.has(c.id) === c.ok;
    const toggle = () => { if (!opened.delete(c.id)) opened.add(c.id); show(); };
    return h("div", { class: "parts" },
      h("button", { class: "link", type: "button", "aria-expanded": String(whole), onclick: toggle }, whole ? "Hide its parts" : held === all.length ? `Its ${say(held, "part")} ${held === 1 ? "holds" : "hold"}: show` : `${held} of its ${say(all.length, "part")} ${held === 1 ? "holds" : "hold"}: show`),
      whole ? h("div", { role: "list", "aria-label": `Parts of ${c.text}` }, all.map(check)) : null);
  }

  const close = () => { if (!adding) return false; adding = false; if (data) show(); return true; };
  return { draw: (next) => { data = next; return checklist(); }, close };
}
