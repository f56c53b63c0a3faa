// Asks one trial after the other. What is shown on a side comes by trial and side alone.
const at = (id) => document.getElementById(id);
const sides = ["left", "right"];
let rater = "", asked = null, since = 0, waiting = false;

at("start").addEventListener("submit", async (event) => {
  event.preventDefault();
  rater = at("rater").value;
  await tell(fetch(`/next?rater=${encodeURIComponent(rater)}`));
});
for (const side of sides) at(side).addEventListener("click", () => choose(side));
addEventListener("keydown", (event) => {
  if (!asked || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "ArrowLeft") choose("left");
  else if (event.key === "ArrowRight") choose("right");
  else if (event.key === " ") replay();
  else return;
  event.preventDefault();
});

async function choose(side) {
  if (!asked || waiting) return;
  waiting = true;
  at(side).classList.add("chosen");
  const seconds = (performance.now() - since) / 1000;
  const body = JSON.stringify({ rater, trial: asked.trial, choice: side, seconds });
  await tell(fetch("/answer", { method: "POST", headers: { "Content-Type": "application/json" }, body }));
  waiting = false;
}

async function tell(request) {
  at("wrong").hidden = true;
  try {
    const reply = await request;
    if (!reply.ok) throw new Error(await reply.text());
    show(await reply.json());
  } catch (error) {
    at("wrong").textContent = `This answer was not kept (${error.message}). Choose again.`;
    at("wrong").hidden = false;
    for (const side of sides) at(side).classList.remove("chosen");
  }
}

function show(told) {
  at("start").hidden = true;
  at("far").textContent = `${told.done} of ${told.of}`;
  at("bar").max = told.of;
  at("bar").value = told.done;
  asked = told.trial === null ? null : told;
  at("ask").hidden = !asked;
  at("end").hidden = Boolean(asked);
  if (!asked) return;
  at("sentence").textContent = told.sentence;
  at("question").textContent = told.question;
  for (const side of sides) {
    const button = at(side);
    button.classList.remove("chosen");
    button.blur();
    button.querySelector(".stage").replaceChildren(...clip(told, side));
  }
  at("ask").dataset.trial = told.trial;
  since = performance.now();
}

function clip(told, side) {
  if (told[side] === "blank") return [];
  const node = document.createElement(told[side] === "video" ? "video" : "img");
  if (told[side] === "video") Object.assign(node, { muted: true, loop: true, autoplay: true, playsInline: true });
  node.src = `/clip/${told.trial}/${side}?rater=${encodeURIComponent(rater)}`;
  return [node];
}

function replay() {
  for (const video of document.querySelectorAll("video")) { video.currentTime = 0; video.play(); }
}
