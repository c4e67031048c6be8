// The marks on the water and the way of the boat: what is drawn over the picture, and the map in its corner.

import { drawTiles, hasMap, onWater } from "./map_tiles.js";

const LINE = "#ffffff";
const EDGE = "#000000";
const COLOURS = { person: "#ff5ec4", place: "#5dd4ff", "way-point": "#5dd4ff", forbidden: "#ff6a4d", home: "#b8ff5d" };
const SIGNS = { person: "P", place: "×", "way-point": "◆", forbidden: "!", home: "H" };
const RAD = Math.PI / 180;
/** Side of the map, CSS pixels, and as a share of the picture's width at most. */
const MAP_PX = 168;
const MAP_SHARE = 0.3;

/** Strokes a path twice, so that it shows on any background. */
function stroke(pen, colour, width, dash = []) {
  pen.setLineDash(dash);
  for (const [style, extra] of [[EDGE, 2.5], [colour, 0]]) {
    [pen.strokeStyle, pen.lineWidth] = [style, width + extra];
    pen.stroke();
  }
  pen.setLineDash([]);
}

function polygon(pen, points) {
  pen.beginPath();
  points.forEach(([x, y], index) => (index ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  pen.closePath();
}

function sign(pen, text, [x, y], colour, unit) {
  pen.font = `800 ${15 * unit}px system-ui, sans-serif`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.lineWidth = 4 * unit;
  pen.strokeStyle = EDGE;
  pen.strokeText(text, x, y);
  pen.fillStyle = colour;
  pen.fillText(text, x, y);
  pen.textAlign = "start";
  pen.textBaseline = "alphabetic";
}

/** Where a point outside of the canvas is shown: at the border, in its direction. */
function atBorder([x, y], [width, height], margin) {
  const [cx, cy] = [width / 2, height / 2];
  const share = Math.min((cx - margin) / Math.max(1, Math.abs(x - cx)), (cy - margin) / Math.max(1, Math.abs(y - cy)));
  return share < 1 ? [cx + share * (x - cx), cy + share * (y - cy)] : [x, y];
}

/** The ring around a mark that is chosen, or dragged. */
export function ringOfMark(pen, [x, y], unit) {
  pen.beginPath();
  pen.arc(x, y, 19 * unit, 0, 2 * Math.PI);
  stroke(pen, LINE, 2 * unit);
}

/**
 * The box of a person that a mark holds, with the sign above it: closed while the person is seen, dashed while
 * the place is predicted.
 */
function drawHeld(pen, view, { kind, held }, colour, width, unit) {
  const [u, v, w, h] = held.box;
  const [left, top] = view.toCanvas([u, v]);
  const [right, bottom] = view.toCanvas([u + w, v + h]);
  const gap = 3 * unit;
  pen.beginPath();
  pen.rect(left - gap, top - gap, right - left + 2 * gap, bottom - top + 2 * gap);
  stroke(pen, colour, width, held.state === "tracking" ? [] : [4 * unit, 4 * unit]);
  sign(pen, SIGNS[kind], [(left + right) / 2, top - 12 * unit], colour, unit);
}

/** The marks with their circles, and the line from the boat to its destination. */
export function drawMarks(pen, view, { vessel, track }, chosen, unit) {
  if (!vessel) return;
  for (const mark of vessel.marks) {
    const colour = COLOURS[mark.kind];
    if (mark.ring.length) {
      polygon(pen, mark.ring.map((point) => view.toCanvas(point)));
      stroke(pen, colour, 1.5 * unit, mark.kind === "forbidden" ? [] : [6 * unit, 5 * unit]);
    }
    if (!mark.at) continue;
    const at = atBorder(view.toCanvas(mark.at), view.canvas, 16 * unit);
    if (mark.destination && track.centre && (vessel.mode === "guided" || vessel.mode === "holding")) {
      pen.beginPath();
      pen.moveTo(...view.toCanvas(track.centre));
      pen.lineTo(...at);
      stroke(pen, colour, 1.5 * unit, [2 * unit, 6 * unit]);
    }
    if (mark.id === chosen) ringOfMark(pen, at, unit);
    const width = (mark.destination ? 3 : 1.5) * unit;
    if (mark.held?.box) {
      drawHeld(pen, view, mark, colour, width, unit);
      continue;
    }
    pen.beginPath();
    pen.arc(...at, (mark.destination ? 15 : 11) * unit, 0, 2 * Math.PI);
    stroke(pen, colour, width, mark.held?.state === "lost" ? [3 * unit, 3 * unit] : []);
    sign(pen, SIGNS[mark.kind], at, colour, unit);
  }
}

/** The water from above: what the camera sees, the marks, and the boat with its course. Ahead is up. */
export function drawMap(pen, view, { vessel, track, boat: seen, water_on_earth: place }, unit) {
  const hasTiles = hasMap(place);
  const isSeen = hasTiles && seen?.on_earth;
  const boat = vessel?.progress ?? (isSeen ? { boat_m: onWater(place, seen.on_earth), course_deg: null } : null);
  const points = [...(vessel?.footprint ?? []), ...(vessel?.marks ?? []).map((mark) => mark.water_m).filter(Boolean)];
  if (boat) points.push(boat.boat_m);
  if (!vessel || points.length < 2) return;
  if (!hasTiles && !vessel.marks.some((mark) => mark.water_m)) return;
  const side = Math.min(MAP_PX * unit, MAP_SHARE * view.canvas[0]);
  // On the side where the boat is not.
  const isBoatRight = track.centre && view.toCanvas(track.centre)[0] > view.canvas[0] / 2;
  const [left, top] = [isBoatRight ? 8 * unit : view.canvas[0] - side - 8 * unit, 8 * unit];
  points.push([0, 0]);
  const range = (axis) => [Math.min(...points.map((point) => point[axis])), Math.max(...points.map((point) => point[axis]))];
  const [[minX, maxX], [minY, maxY]] = [range(0), range(1)];
  const scale = (side - 24 * unit) / Math.max(10, maxX - minX, maxY - minY);
  const middle = [(minX + maxX) / 2, (minY + maxY) / 2];
  const to = ([x, y]) => [left + side / 2 + (x - middle[0]) * scale, top + side / 2 - (y - middle[1]) * scale];
  pen.save();
  pen.beginPath();
  pen.rect(left, top, side, side);
  pen.fillStyle = "rgba(4, 24, 38, 0.82)";
  pen.fill();
  stroke(pen, LINE, unit);
  pen.clip();
  if (hasTiles) drawTiles(pen, place, to([0, 0]), scale, [left, top, side], unit);
  if (vessel.footprint) {
    polygon(pen, vessel.footprint.map(to));
    stroke(pen, "#9bb4c4", unit, [4 * unit, 4 * unit]);
  }
  for (const mark of vessel.marks) {
    if (!mark.water_m) continue;
    const colour = COLOURS[mark.kind];
    const at = to(mark.water_m);
    if (mark.radius_m) {
      pen.beginPath();
      pen.arc(...at, (mark.radius_m + (mark.std_dev_m ?? 0)) * scale, 0, 2 * Math.PI);
      stroke(pen, colour, unit);
    }
    sign(pen, SIGNS[mark.kind], at, colour, unit);
    if (mark.destination && boat) {
      pen.beginPath();
      pen.moveTo(...to(boat.boat_m));
      pen.lineTo(...at);
      stroke(pen, colour, unit, [2 * unit, 4 * unit]);
    }
  }
  if (boat) {
    const at = to(boat.boat_m);
    const course = (boat.course_deg ?? 0) * RAD;
    const turned = (forward, aside) => [at[0] + (forward * Math.sin(course) + aside * Math.cos(course)) * unit, at[1] - (forward * Math.cos(course) - aside * Math.sin(course)) * unit];
    polygon(pen, boat.course_deg === null ? [[at[0] - 5 * unit, at[1]], [at[0], at[1] - 5 * unit], [at[0] + 5 * unit, at[1]], [at[0], at[1] + 5 * unit]] : [turned(10, 0), turned(-6, 5), turned(-6, -5)]);
    pen.fillStyle = "#5dff9b";
    pen.fill();
    stroke(pen, "#5dff9b", unit);
  }
  // A scale of ten metres.
  pen.beginPath();
  pen.moveTo(left + 8 * unit, top + side - 8 * unit);
  pen.lineTo(left + 8 * unit + 10 * scale, top + side - 8 * unit);
  stroke(pen, LINE, 2 * unit);
  pen.font = `600 ${11 * unit}px system-ui, sans-serif`;
  pen.fillStyle = LINE;
  pen.fillText("10 m", left + 8 * unit, top + side - 13 * unit);
  pen.restore();
}
