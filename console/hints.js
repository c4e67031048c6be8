// The hints of the first minute, each shown once, over the picture's edge; and the mark that points at the
// boat of a simulated world until it is selected.

import { words } from "./words.js";

const at = (id) => document.getElementById(id);
const KEPT = "hintsSeen";

/** Each hint: when it is of use, and when the operator has done what it says. */
const HINTS = [
  { name: "select", isOfUse: ({ track }) => track.state === "unseeded", isDone: ({ track }) => track.state !== "unseeded" },
  { name: "drive", isOfUse: ({ track, vessel }) => vessel && track.state !== "unseeded", isDone: ({ vessel }) => vessel?.mode === "by-hand" },
  { name: "rescue", isOfUse: ({ track, vessel }) => vessel && track.state !== "unseeded", isDone: ({ vessel }) => vessel?.mode === "guided" },
];

export class Hints {
  #stage;
  #seen = new Set((localStorage.getItem(KEPT) ?? "").split(",").filter(Boolean));
  #shown = null;

  /** @param {import("./stage.js").Stage} stage */
  constructor(stage) {
    this.#stage = stage;
    at("hint-close").addEventListener("click", () => this.#dismiss());
  }

  /** Shows all hints again. */
  again() {
    this.#seen.clear();
    this.#keep();
  }

  /** @param {any} snapshot */
  tick(snapshot) {
    const shown = this.#shown;
    if (shown && shown.isDone(snapshot)) this.#dismiss();
    this.#shown = HINTS.find(({ name, isOfUse }) => !this.#seen.has(name) && isOfUse(snapshot)) ?? null;
    at("hint").hidden = this.#shown === null;
    if (this.#shown && at("hint").dataset.hint !== this.#shown.name) {
      at("hint").dataset.hint = this.#shown.name;
      at("hint-text").textContent = words.hints[this.#shown.name];
    }
    this.#point(snapshot);
    if (this.#shown) this.#avoid(snapshot);
  }

  #dismiss() {
    if (this.#shown) this.#seen.add(this.#shown.name);
    this.#shown = null;
    at("hint").hidden = true;
    this.#keep();
  }

  #keep() {
    localStorage.setItem(KEPT, [...this.#seen].join());
  }

  /** A box of the picture on the page, within the stage: left, top, right, bottom. */
  #onPage([u, v, w, h]) {
    const { view } = this.#stage;
    if (!view.picture) return null;
    const [unit, canvas] = [window.devicePixelRatio || 1, at("picture")];
    const corner = (point) => view.toCanvas(point).map((value, axis) => value / unit + [canvas.offsetLeft, canvas.offsetTop][axis]);
    return [...corner([u, v]), ...corner([u + w, v + h])];
  }

  /** Points at the boat of the world, while nothing is selected. */
  #point({ world, track, proposal }) {
    const box = world?.boat && track.state === "unseeded" && !track.confirming && !proposal ? this.#onPage(world.boat) : null;
    const pointer = at("boat-pointer");
    pointer.hidden = box === null;
    document.documentElement.dataset.pointer = box ? box.map(Math.round).join() : "";
    if (!box) return;
    const margin = 10;
    const [left, top, right, bottom] = [box[0] - margin, box[1] - margin, box[2] + margin, box[3] + margin];
    Object.assign(pointer.style, { left: `${left}px`, top: `${top}px`, width: `${right - left}px`, height: `${bottom - top}px` });
    const { clientWidth: width } = at("picture");
    // The text stands above the box, or below it, and within the picture.
    pointer.classList.toggle("below", top < 60);
    pointer.classList.toggle("to-left", left + pointer.firstElementChild.offsetWidth > width);
  }

  /** The hint moves to the upper edge while the boat is at the lower one. */
  #avoid({ track, world }) {
    const bounds = track.bounds ?? world?.boat;
    const box = bounds ? this.#onPage(bounds) : null;
    const { offsetTop, clientHeight } = at("picture");
    const isLow = box !== null && (box[1] + box[3]) / 2 > offsetTop + clientHeight / 2 + 10;
    at("hint").classList.toggle("high", isLow);
  }
}
