// What is drawn over the picture: region, sectors, box, axis, heading, trail, P, commands.

import { drawMap, drawMarks } from "./marks.js";
import { fixed, words } from "./words.js";

export const LAYERS = ["region", "box", "heading", "trail", "p", "command", "advice", "marks", "map"];

/** Width of the canvas from which the map is drawn for the operator, CSS pixels. */
const MAP_FROM_PX = 700;

const LINE = "#ffffff";
const EDGE = "#000000";
const WARM = "#ffb000";
const RAD = Math.PI / 180;

/** Strokes a path twice, so that it shows on any background. */
function stroke(pen, colour, width, dash = []) {
  pen.setLineDash(dash);
  pen.strokeStyle = EDGE;
  pen.lineWidth = width + 3;
  pen.globalAlpha = 0.55;
  pen.stroke();
  pen.globalAlpha = 1;
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.stroke();
  pen.setLineDash([]);
}

function arrow(pen, [x, y], [dx, dy], colour, isHollow, unit) {
  const length = Math.hypot(dx, dy);
  if (length < 1) return;
  const [u, v] = [dx / length, dy / length];
  const [tipX, tipY, w] = [x + dx, y + dy, 9 * unit];
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(tipX - u * w, tipY - v * w);
  stroke(pen, colour, 4 * unit, isHollow ? [6 * unit, 5 * unit] : []);
  pen.beginPath();
  pen.moveTo(tipX, tipY);
  pen.lineTo(tipX - u * 2 * w - v * w, tipY - v * 2 * w + u * w);
  pen.lineTo(tipX - u * 2 * w + v * w, tipY - v * 2 * w - u * w);
  pen.closePath();
  if (isHollow) stroke(pen, colour, 2 * unit);
  else {
    pen.fillStyle = colour;
    pen.fill();
    stroke(pen, colour, 1 * unit);
  }
}

/** How long the trail is. */
const TRAIL_NS = 5e9;

/** The trail of the target over the last seconds. */
export class Trail {
  #points = [];

  /** Adds where the target is. The trail gets older also while the target is lost. */
  add({ track: { centre, captured_ns: captured }, video }) {
    const isNew = centre && captured !== this.#points.at(-1)?.captured;
    if (isNew && captured < this.#points.at(-1)?.captured) this.#points = [];
    if (isNew) this.#points.push({ centre, captured });
    const now = Math.max(video.captured_ns ?? 0, captured ?? 0);
    while (this.#points.length && now - this.#points[0].captured > TRAIL_NS) this.#points.shift();
  }

  clear() {
    this.#points = [];
  }

  draw(pen, view, unit) {
    pen.beginPath();
    this.#points.forEach(({ centre }, index) => {
      const [x, y] = view.toCanvas(centre);
      if (index) pen.lineTo(x, y);
      else pen.moveTo(x, y);
    });
    stroke(pen, LINE, 1.5 * unit, [2 * unit, 4 * unit]);
  }
}

/** P from which the calm ellipse gets brighter: the boat is near its border. */
const NEAR_P = 0.6;

function drawRegion(pen, view, snapshot, isCalm, unit) {
  const { region, percept } = snapshot;
  if (!region) return;
  const [width, height] = view.picture;
  const [cx, cy] = view.toCanvas([width / 2, height / 2]);
  const [a, b] = [region.a_px * view.scale, region.b_px * view.scale];
  pen.beginPath();
  pen.ellipse(cx, cy, a, b, 0, 0, 2 * Math.PI);
  const isOutside = percept && percept.p > 1;
  if (isCalm) {
    const nearness = Math.min(1, Math.max(0, ((percept?.p ?? 0) - NEAR_P) / (1 - NEAR_P)));
    [pen.strokeStyle, pen.lineWidth, pen.globalAlpha] = [isOutside ? WARM : LINE, (1 + nearness) * unit, 0.3 + 0.6 * nearness];
    pen.stroke();
    pen.globalAlpha = 1;
    return;
  }
  stroke(pen, isOutside ? WARM : LINE, (isOutside ? 3 : 2) * unit);
  pen.beginPath();
  for (const [sx, sy] of [[1, 1], [1, -1], [-1, 1], [-1, -1]]) {
    // The sectors divide at 45 degrees of the picture.
    const t = (a * b) / Math.hypot(a, b);
    const reach = Math.min(width, height) * 0.5 * view.scale;
    pen.moveTo(cx + sx * t, cy + sy * t);
    pen.lineTo(cx + sx * reach, cy + sy * reach);
  }
  stroke(pen, LINE, 1 * unit, [4 * unit, 8 * unit]);
}

function drawBox(pen, view, track, unit) {
  const [u, v, w, h] = track.box;
  const [x, y] = view.toCanvas([u, v]);
  pen.beginPath();
  pen.rect(x, y, w * view.scale, h * view.scale);
  const isSure = track.state === "tracking" && !track.confirming && !track.doubted;
  stroke(pen, isSure ? "#5dff9b" : WARM, 2.5 * unit, isSure ? [] : [8 * unit, 6 * unit]);
  if (track.axis_deg !== null && track.axes) {
    const [cx, cy] = view.toCanvas(track.centre);
    const half = (track.axes[0] / 2) * view.scale;
    const [dx, dy] = [Math.cos(track.axis_deg * RAD) * half, -Math.sin(track.axis_deg * RAD) * half];
    pen.beginPath();
    pen.moveTo(cx - dx, cy - dy);
    pen.lineTo(cx + dx, cy + dy);
    stroke(pen, LINE, 1.5 * unit);
  }
}

/** The object that is proposed: dashed, with a word above it. */
export function drawProposal(pen, view, [u, v, w, h], unit) {
  const [x, y] = view.toCanvas([u, v]);
  pen.beginPath();
  pen.rect(x, y, w * view.scale, h * view.scale);
  stroke(pen, LINE, 2.5 * unit, [6 * unit, 5 * unit]);
  drawText(pen, words.proposed, [x, y], unit);
}

/**
 * An object that may be the wanted one, with what a detector says it is.
 * @param {boolean} isNumbered whether its number can be taken
 */
function drawCandidate(pen, view, { box: [u, v, w, h], number, class: name, score, mark }, isNumbered, unit) {
  const [x, y] = view.toCanvas([u, v]);
  pen.beginPath();
  pen.rect(x, y, w * view.scale, h * view.scale);
  stroke(pen, LINE, 1.5 * unit, [2 * unit, 4 * unit]);
  const said = name && `${name} ${fixed(score, 2)}${mark ? words.tapToMark : ""}`;
  drawText(pen, [isNumbered && number, said].filter(Boolean).join(": "), [x, y], unit);
}

/** A text above a corner of a box, within the picture. */
function drawText(pen, text, [x, y], unit) {
  pen.font = `700 ${15 * unit}px system-ui, sans-serif`;
  pen.lineWidth = 4 * unit;
  pen.strokeStyle = EDGE;
  pen.fillStyle = LINE;
  const mostRight = pen.canvas.width - pen.measureText(text).width - 4;
  const [left, top] = [Math.max(4, Math.min(x, mostRight)), Math.max(18 * unit, y - 7 * unit)];
  pen.strokeText(text, left, top);
  pen.fillText(text, left, top);
}

function drawCommand(pen, view, pair, isHollow, unit) {
  const [cx, cy] = [view.canvas[0] / 2, view.canvas[1] / 2];
  const length = (rate) => Math.sign(rate) * (30 + 300 * Math.abs(rate)) * unit;
  const colour = isHollow ? LINE : WARM;
  if (pair.pan) arrow(pen, [cx, cy], [length(pair.pan), 0], colour, isHollow, unit);
  if (pair.tilt) arrow(pen, [cx, cy], [0, -length(pair.tilt)], colour, isHollow, unit);
}

/**
 * Draws the layers that are switched on.
 * @param {{trail: Trail, layers: Set<string>, isCalm: boolean, chosenMark: number | null, label: string, unit: number}} options `label`:
 *   the text beside the box
 */
export function drawOverlay(pen, view, snapshot, { trail, layers: shown, isCalm, chosenMark, label, unit }) {
  const { track } = snapshot;
  if (shown.has("region")) drawRegion(pen, view, snapshot, isCalm, unit);
  if (shown.has("trail")) trail.draw(pen, view, unit);
  if (shown.has("marks")) drawMarks(pen, view, snapshot, chosenMark, unit);
  // In a small picture the map would cover too much.
  if (shown.has("map") && (!isCalm || view.canvas[0] >= MAP_FROM_PX * unit)) drawMap(pen, view, snapshot, unit);
  const isNumbered = snapshot.candidates_on_demand || track.state === "unseeded";
  for (const candidate of snapshot.candidates ?? []) drawCandidate(pen, view, candidate, isNumbered, unit);
  if (track.box && shown.has("box")) drawBox(pen, view, track, unit);
  if (track.heading_deg !== null && track.centre && shown.has("heading")) {
    const reach = (0.5 * (track.axes?.[0] ?? 40) + 24) * view.scale;
    const direction = [Math.cos(track.heading_deg * RAD) * reach, -Math.sin(track.heading_deg * RAD) * reach];
    arrow(pen, view.toCanvas(track.centre), direction, LINE, false, 0.6 * unit);
  }
  const isMoving = snapshot.command.pan !== 0 || snapshot.command.tilt !== 0;
  if (isMoving && shown.has("command")) drawCommand(pen, view, snapshot.command, false, unit);
  else if (snapshot.advice && shown.has("advice")) drawCommand(pen, view, snapshot.advice, true, unit);
  if (track.box && shown.has("p") && label) drawText(pen, label, view.toCanvas([track.box[0], track.box[1]]), unit);
}
