// Scissors: a line along the picture's edges, from anchor to anchor, that encloses what is cut.

import { send } from "./wire.js";

const MOST = 590; // points of a line that are kept
const NEAR = 9; // pixels of the screen from the first anchor at which a click closes the line

export function makeScissors({ state, stage, changed, target, ticket, alter, refused }) {
  function way(end, straight) {
    const cut = state.cut;
    if (straight) {
      cut.live = [cut.anchors.at(-1), end];
      return changed();
    }
    cut.ticket = ticket();
    if (!send({ do: "edge", start: cut.anchors.at(-1), end, ticket: cut.ticket })) cut.fixing = "";
  }

  function edge(answer) {
    const cut = state.cut;
    if (!cut || answer.ticket !== cut.ticket) return;
    if (!answer.points) return refused();
    cut.live = answer.points;
    if (cut.fixing) {
      const closing = cut.fixing === "close";
      cut.ways.push(cut.live);
      if (!closing) cut.anchors.push(cut.live.at(-1));
      [cut.fixing, cut.live] = ["", null];
      if (closing) finish();
    }
    changed();
  }

  function anchor(point, straight) {
    if (!state.cut) state.cut = { name: target(), anchors: [point], ways: [], live: null, fixing: "", ticket: 0 };
    else if (!state.cut.fixing) {
      const first = state.cut.anchors[0];
      const near = Math.hypot(first[0] - point[0], first[1] - point[1]) < NEAR * stage.unit();
      if (near && state.cut.anchors.length > 1) return close(straight);
      if (straight) {
        state.cut.ways.push([state.cut.anchors.at(-1), point]);
        state.cut.anchors.push(point);
        state.cut.live = null;
      } else {
        state.cut.fixing = "anchor";
        way(point, false);
      }
    }
    changed();
  }

  function close(straight) {
    const cut = state.cut;
    if (!cut || cut.fixing || cut.anchors.length < 2) return;
    if (straight || cut.anchors.length < 3) {
      if (cut.anchors.length < 3 && cut.ways.flat().length < 3) return;
      cut.ways.push([cut.anchors.at(-1), cut.anchors[0]]);
      return finish();
    }
    cut.fixing = "close";
    way(cut.anchors[0], false);
  }

  function finish() {
    let points = state.cut.ways.flat();
    const every = Math.ceil(points.length / MOST);
    points = points.filter((_, i) => i % every === 0);
    state.cut = null;
    if (points.length > 2) alter((g) => g.strokes.push({ tool: "scissors", effect: state.effect, radius: 1, points }));
    changed();
  }

  return { way, edge, anchor, close };
}
