// A box, or a point, that is chosen by keyboard. Pure.

import { boxBetween } from "./geometry.js";

export const MIN_BOX_PX = 4;
const STEP_PX = 8;
/** Side of the frame around a point that is chosen by keyboard. */
const POINT_PX = 24;
const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** The first box: around the target, or in the middle; or the frame of a point. */
export function firstBox([width, height], centre, isPoint) {
  const [w, h] = isPoint ? [POINT_PX, POINT_PX] : [width / 8, height / 8];
  const [u, v] = (!isPoint && centre) || [width / 2, height / 2];
  return boxBetween([u - w / 2, v - h / 2], [u + w / 2, v + h / 2], [width, height]);
}

/** The box after an arrow key, moved or resized; `null`: the key is none. */
export function steppedBox([u, v, w, h], key, isResized, [width, height]) {
  if (!STEPS[key]) return null;
  const [dx, dy] = STEPS[key].map((step) => step * STEP_PX);
  return isResized
    ? [u, v, Math.max(MIN_BOX_PX, w + dx), Math.max(MIN_BOX_PX, h + dy)]
    : [Math.min(width - w, Math.max(0, u + dx)), Math.min(height - h, Math.max(0, v + dy)), w, h];
}
