// Building and updating the page. Text always goes in as text, never as markup.

const SVG = "http://www.w3.org/2000/svg";
const SVG_TAGS = new Set(["svg", "g", "rect", "line", "path", "text", "circle", "polygon", "polyline", "title", "image"]);
const AS_PROPERTY = new Set(["value", "checked", "disabled", "hidden", "selected", "readOnly", "open"]);

export const SECOND_CLICK = 600; // ms after the first, as long as people double-click

export function h(tag, props, ...kids) {
  const node = SVG_TAGS.has(tag) ? document.createElementNS(SVG, tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(props || {})) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) node[name] = value;
    else if (AS_PROPERTY.has(name)) node[name] = value;
    else if (name === "key") node.dataset.key = value;
    else node.setAttribute(name, value === true ? "" : value);
  }
  // What the server holds, so that typing is only overwritten by something new.
  if (props && "value" in props && ["INPUT", "TEXTAREA", "SELECT"].includes(node.tagName)) node.dataset.server = String(props.value);
  add(node, kids);
  if (props && "value" in props && node.tagName === "SELECT") node.value = props.value;
  return node;
}

function add(node, kids) {
  for (const kid of kids.flat(9)) {
    if (kid === null || kid === undefined || kid === false || kid === "") continue;
    node.append(kid instanceof Node ? kid : document.createTextNode(String(kid)));
  }
}

// Makes the children of `target` look like `kids`, keeping nodes, focus and what is being typed.
export function draw(target, ...kids) {
  const box = document.createDocumentFragment();
  const held = document.activeElement;
  add(box, kids);
  children(target, box);
  // A node that had to be moved has lost the focus.
  if (held && held !== document.activeElement && held !== document.body && target.contains(held)) held.focus({ preventScroll: true });
}

function children(old, fresh) {
  const keyed = new Map();
  for (const node of old.children || []) if (node.dataset && node.dataset.key) keyed.set(node.dataset.key, node);
  let at = old.firstChild;
  for (const next of [...fresh.childNodes]) {
    const key = next.dataset && next.dataset.key;
    let match = key ? keyed.get(key) : at;
    if (match && !key && match.dataset && match.dataset.key) match = null;
    if (match && same(match, next)) {
      // Nodes without a key between here and there are gone; keyed ones may still be wanted.
      while (key && at && at !== match && !(at.dataset && at.dataset.key)) {
        const gone = at;
        at = at.nextSibling;
        gone.remove();
      }
      if (match !== at) old.insertBefore(match, at);
      else at = at.nextSibling;
      patch(match, next);
    } else old.insertBefore(next, at);
  }
  while (at) {
    const gone = at;
    at = at.nextSibling;
    gone.remove();
  }
}

const same = (a, b) => a.nodeType === b.nodeType && a.nodeName === b.nodeName && (a.type || "") === (b.type || "");

function patch(old, next) {
  if (old.nodeType === Node.TEXT_NODE) {
    if (old.data !== next.data) old.data = next.data;
    return;
  }
  const server = old.dataset && old.dataset.server;
  // What is typed and cannot be used stays marked as long as it stands there.
  const wrong = server !== undefined && old.classList.contains("wrong") && (server === next.dataset.server || document.activeElement === old);
  for (const { name } of [...old.attributes]) if (!next.hasAttribute(name)) old.removeAttribute(name);
  for (const { name, value } of next.attributes) if (old.getAttribute(name) !== value) old.setAttribute(name, value);
  for (const name of ["onclick", "oninput", "onchange", "onkeydown", "onkeyup", "onpointerdown", "onpointermove", "onpointerup", "onpointercancel", "onpointerleave", "onpointerenter", "onblur", "onfocus", "onscroll", "ondblclick", "oncontextmenu", "onsubmit", "onload", "onerror", "ondragover", "ondragleave", "ondrop"]) {
    if (old[name] !== next[name]) old[name] = next[name];
  }
  for (const name of ["disabled", "hidden", "checked", "readOnly", "selected"]) if (name in next && old[name] !== next[name]) old[name] = next[name];
  if (old.nodeName === "SELECT") children(old, next);
  if (next.dataset && next.dataset.server !== undefined && server !== next.dataset.server) {
    if (document.activeElement !== old || old.nodeName === "SELECT") old.value = next.value;
  }
  if (wrong) old.classList.add("wrong");
  if (old.nodeName !== "TEXTAREA" && old.nodeName !== "SELECT") children(old, next);
}

// A place that a file can be dropped on.
export const dropping = (take) => ({
  ondragover: (event) => { event.preventDefault(); event.currentTarget.classList.add("over"); },
  ondragleave: (event) => event.currentTarget.classList.remove("over"),
  ondrop: (event) => { event.preventDefault(); event.currentTarget.classList.remove("over"); take(event.dataTransfer.files[0]); },
});

// Tab goes round inside a dialog.
export function keepInside(event) {
  if (event.key !== "Tab") return;
  const stops = [...event.currentTarget.querySelectorAll("button, input, select, textarea, a[href], [tabindex]")].filter((one) => !one.disabled && one.tabIndex >= 0 && one.offsetParent);
  const edge = event.shiftKey ? stops[0] : stops[stops.length - 1];
  if (!stops.length || (document.activeElement !== edge && event.currentTarget.contains(document.activeElement))) return;
  event.preventDefault();
  (event.shiftKey ? stops[stops.length - 1] : stops[0]).focus();
}

export const button = (text, onclick, props) => h("button", { class: "b", type: "button", ...props, onclick }, text);
// One colour for each thing, in its order: in the photo, the plots and the lanes alike.
export const COLORS = ["#e26248", "#4287c6", "#f0b23e", "#5ea86c", "#9e6cba", "#48b0b4", "#d678a0", "#8c7660"];
export const colorOf = (at) => COLORS[at % COLORS.length];
export const spoken = (name) => name.replaceAll("_", " ");
export const say = (count, one, many) => `${count} ${count === 1 ? one : many || one + "s"}`;

const PATHS = {
  play: "M5 3.5v9l7-4.5z", pause: "M4 3h3v10H4zM9 3h3v10H9z", first: "M3 3h2v10H3zM13 3v10L6 8z", last: "M11 3h2v10h-2zM3 3v10l7-5z",
  back: "M11 3v10L4 8z", on: "M5 3v10l7-5z", loop: "M4 5h6a3 3 0 0 1 0 6H5l1.500-1.500-1-1L2.500 11.500l3 3 1-1L5 12.500h5a4.500 4.500 0 0 0 0-9H4z",
  undo: "M6 3 2.500 6.500 6 10V7.700h3a2.200 2.200 0 0 1 0 4.500H6V14h3a4 4 0 0 0 0-8H6z", redo: "M10 3l3.500 3.500L10 10V7.700H7a2.200 2.200 0 0 0 0 4.500h3V14H7a4 4 0 0 1 0-8h3z",
  pin: "M9.500 2 14 6.500l-1 .9-.8-.3-2.700 2.700.2 2.200-1 1L6 10.300 2.800 13.500l-.6.1.1-.6L5.500 9.800 2.800 7.100l1-1 2.200.2 2.700-2.700-.3-.8z",
  pen: "M3 11.200V13h1.800l6.700-6.700-1.800-1.800zM13.700 4.100 11.900 2.300l-1.400 1.400 1.800 1.800z", copy: "M5.500 2H12a1.500 1.500 0 0 1 1.500 1.500V10H12V3.500H5.500zM3.500 5H9a1.500 1.500 0 0 1 1.500 1.500v6A1.500 1.500 0 0 1 9 14H3.500A1.500 1.500 0 0 1 2 12.500v-6A1.500 1.500 0 0 1 3.500 5z", bin: "M6 2h4l.7 1H13v1.500H3V3h2.300zM4 5.500h8L11.300 14H4.700zM6.500 7v5.500h1V7zm2 0v5.500h1V7z",
  moon: "M13 9.500A5.500 5.500 0 0 1 6.500 3a5.500 5.500 0 1 0 6.500 6.500z", more: "M3 7h2v2H3zM7 7h2v2H7zM11 7h2v2h-2z", help: "M8 2a6 6 0 1 0 0 12A6 6 0 0 0 8 2zm-.8 9h1.600v1.500H7.200zm2.700-4.300c-.5.6-1.100.9-1.100 1.700v.6H7.300v-.8c0-1.200.8-1.700 1.300-2.200.3-.3.400-.6.400-.9 0-.6-.4-.9-1-.9-.7 0-1.100.4-1.100 1.100H5.300c0-1.600 1.200-2.600 2.700-2.600s2.700.9 2.700 2.300c0 .7-.3 1.200-.8 1.700z",
};
export function icon(name) {
  return h("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, h("path", { d: PATHS[name], fill: "currentColor" }));
}
export const iconButton = (name, label, onclick, props) =>
  h("button", { class: "b quiet icon", type: "button", title: label, "aria-label": label, ...props, onclick }, icon(name));
