// How the 3D view draws: as well as a graphics card can, or lightly, as a processor has to.

import { h } from "./dom.js";

const KEY = "studio.drawing";
const CHOICES = { auto: "automatic", light: "lightly", full: "with all it has" };
const chosen = () => {
  const kept = localStorage.getItem(KEY);
  return kept in CHOICES ? kept : "auto";
};

// What to put behind the viewer's address.
export function viewerQuery(dark) {
  const words = [dark ? "darkMode" : "", chosen() === "auto" ? "" : chosen()].filter(Boolean);
  return words.length ? `?${words.join("&")}` : "";
}

const words = () => {
  const found = document.getElementById("viewer").contentWindow?.studioDrawing;
  const now = found ? ` Now: ${found.light ? CHOICES.light : CHOICES.full}, by ${found.renderer || "what does not say its name"}.` : "";
  return `Lightly suits a machine without a graphics card: edges are not smoothed.${now}`;
};

// The choice, for the Scene tab. Another one opens the view anew.
export function drawingChoice() {
  const take = (event) => { localStorage.setItem(KEY, event.target.value); dispatchEvent(new Event("drawing")); };
  return h("label", { class: "row", onpointerenter: (event) => { event.currentTarget.title = words(); } },
    h("span", { class: "grow" }, "Draw"),
    h("select", { "aria-label": "How to draw", style: "width:auto", value: chosen(), onchange: take },
      Object.entries(CHOICES).map(([key, text]) => h("option", { value: key }, text))));
}
