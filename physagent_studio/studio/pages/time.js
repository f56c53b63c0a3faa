// Time: seconds of the event stand in front; frames are beside them.

import { value } from "./wire.js";

export const moment = (frame) => {
  const line = value("timeline");
  return line ? `at ${(frame * line.stepsPerFrame * line.stepSeconds).toFixed(2)} s` : `frame ${frame}`;
};
