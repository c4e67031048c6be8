// The canvas: the picture with its overlay, zoom and pan, and the box that the operator draws.

import { View, boxBetween } from "./geometry.js";
import { MIN_BOX_PX, firstBox, steppedBox } from "./key_box.js";
import { ringOfMark } from "./marks.js";
import { Trail, drawOverlay, drawProposal } from "./overlay.js";

/** How long a picture stays frozen, ms. The program keeps video frames for 1.5 s after their capture. */
export const FROZEN_MS = 1300;
/** A pointer that moved less is a tap, CSS pixels. */
const TAP_PX = 12;

export class Stage extends EventTarget {
  #canvas;
  #pen;
  #picture = document.createElement("canvas");
  #shown = null;
  #frozenAt = null;
  #pointers = new Map();
  #drag = null;
  #keyBox = null;
  #pinch = null;
  view = new View();
  trail = new Trail();
  layers = new Set();
  /** Whether little is drawn: for who looks at the boat, not at the law. */
  isCalm = false;
  /** Number of the mark that was tapped last. @type {number | null} */
  chosenMark = null;
  /** Whether the next point is a mark, not a box. */
  isMarking = false;
  /** Whether the boat is followed in another video than the shown one. */
  isWatchedOnly = false;
  /** The object that is proposed: left, top, width, height. @type {number[] | null} */
  #proposal = null;
  /** A box that stays: left, top, width, height. @type {number[] | null} */
  kept = null;

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    super();
    this.#canvas = canvas;
    this.#pen = canvas.getContext("2d", { alpha: false });
    new ResizeObserver(() => this.redraw()).observe(canvas);
    this.#listen();
  }

  /** Shows a picture. A frozen picture stays. */
  show(image, quarters, { captured, snapshot }) {
    if (snapshot) this.trail.add(snapshot);
    if (this.isFrozen) return;
    if (!snapshot) this.#keyBox = null;
    // Of a video frame the pixels, also where they are not square: boxes are measured in them.
    const { width, height } = image.visibleRect ?? image;
    const isTurned = quarters % 2 === 1;
    const size = isTurned ? [height, width] : [width, height];
    if (this.#picture.width !== size[0] || this.#picture.height !== size[1]) {
      [this.#picture.width, this.#picture.height] = size;
      this.#canvas.dataset.size = size.join("x");
    }
    const pen = this.#picture.getContext("2d", { alpha: false });
    pen.setTransform(1, 0, 0, 1, 0, 0);
    if (quarters) {
      pen.translate(size[0] / 2, size[1] / 2);
      pen.rotate((quarters * Math.PI) / 2);
      pen.translate(-width / 2, -height / 2);
    }
    pen.drawImage(image, 0, 0, width, height);
    this.#shown = { captured, snapshot };
    this.redraw();
  }

  /** Shows nothing. What is being drawn is dropped. */
  clear() {
    [this.#shown, this.#drag, this.#keyBox] = [null, null, null];
    this.trail.clear();
    this.#picture.getContext("2d").clearRect(0, 0, this.#picture.width, this.#picture.height);
    this.redraw();
  }

  /** Shows what is proposed, also while no picture comes. @param {number[] | null} box */
  setProposal(box) {
    if (String(box) === String(this.#proposal)) return;
    this.#proposal = box;
    this.redraw();
  }

  get hasPicture() {
    return this.#shown !== null;
  }

  /** Whether the box lies in the lower half of what is shown. */
  get isBoxLow() {
    const centre = this.#shown?.snapshot?.track.centre;
    return Boolean(centre && this.view.canvas && this.view.toCanvas(centre)[1] > this.view.canvas[1] / 2);
  }

  get isFrozen() {
    return this.#frozenAt !== null;
  }

  /** Share of the time left for drawing on the frozen picture. */
  get frozenShare() {
    return this.isFrozen ? Math.max(0, 1 - (performance.now() - this.#frozenAt) / FROZEN_MS) : 0;
  }

  freeze() {
    if (!this.#shown || this.isFrozen) return;
    this.#frozenAt = performance.now();
    this.#change();
  }

  unfreeze() {
    this.#frozenAt = null;
    this.#change();
  }

  /** To be called often: ends a freeze that lasts too long. A box that is being drawn goes on, on the moving picture. */
  tick() {
    if (!this.isFrozen) return;
    if (this.frozenShare === 0) {
      this.unfreeze();
      if (this.#drag?.from && !this.#drag.mark) this.#say("old");
    }
    this.#change();
  }

  #change() {
    this.dispatchEvent(new Event("change"));
    this.redraw();
  }

  #say(reason) {
    this.dispatchEvent(new CustomEvent("say", { detail: reason }));
  }

  /** Whether the next point is a mark. */
  setMarking(isMarking) {
    [this.isMarking, this.#keyBox] = [isMarking, null];
    this.#change();
  }

  #mark(at, captured) {
    this.setMarking(false);
    this.dispatchEvent(new CustomEvent("mark", { detail: { at, captured_ns: captured } }));
  }

  #select(box, captured) {
    if (box[2] < MIN_BOX_PX || box[3] < MIN_BOX_PX) return this.#say("small");
    this.dispatchEvent(new CustomEvent("select", { detail: { box, captured_ns: captured } }));
  }

  /** Whether a drag is none of a tap: its pointer has moved. */
  #isMoved({ from, to }) {
    return Math.hypot(to[0] - from[0], to[1] - from[1]) * this.view.scale > TAP_PX * (window.devicePixelRatio || 1);
  }

  /** The mark whose sign is at this place of the canvas. */
  #markAt([x, y]) {
    const reach = 22 * (window.devicePixelRatio || 1);
    const marks = this.#shown?.snapshot?.vessel?.marks ?? [];
    return marks.find(({ at }) => {
      if (!at) return false;
      const [u, v] = this.view.toCanvas(at);
      return Math.hypot(u - x, v - y) <= reach;
    });
  }

  /** The candidate at this place of the canvas for which a mark is proposed. */
  #proposedMarkAt([x, y]) {
    const reach = TAP_PX * (window.devicePixelRatio || 1);
    return (this.#shown?.snapshot?.candidates ?? []).find(({ mark, box: [u, v, w, h] }) => {
      if (!mark) return false;
      const [[left, top], [right, bottom]] = [this.view.toCanvas([u, v]), this.view.toCanvas([u + w, v + h])];
      return x >= left - reach && x <= right + reach && y >= top - reach && y <= bottom + reach;
    });
  }

  /** Proposes what is tapped: the object there, or a mark on the person whom a detector sees there. */
  #tap({ from, captured }) {
    const candidate = this.#proposal ? null : this.#proposedMarkAt(this.view.toCanvas(from));
    if (!candidate) return this.dispatchEvent(new CustomEvent("propose", { detail: { at: from, captured_ns: captured } }));
    const { box: [u, v, w, h], mark, captured_ns } = candidate;
    this.dispatchEvent(new CustomEvent("mark", { detail: { mark, at: [u + w / 2, v + h / 2], captured_ns } }));
  }

  /** Where an event is on the canvas, device pixels. */
  #at(event) {
    const area = this.#canvas.getBoundingClientRect();
    const ratio = this.#canvas.width / area.width;
    return [(event.clientX - area.left) * ratio, (event.clientY - area.top) * ratio];
  }

  #listen() {
    const canvas = this.#canvas;
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button > 1) return;
      canvas.setPointerCapture(event.pointerId);
      this.#pointers.set(event.pointerId, this.#at(event));
      if (this.#pointers.size === 2) this.#beginPinch();
      else if (event.button === 1) this.#drag = { pan: this.#at(event) };
      else if (!this.#shown) this.#say("noPicture");
      else if (this.isWatchedOnly) this.#say("watchedOnly");
      else {
        // While the picture is frozen, a box can be drawn where a mark is.
        const mark = this.isMarking || this.isFrozen ? null : this.#markAt(this.#at(event));
        if (!mark) this.freeze();
        const from = this.view.toPicture(this.#at(event));
        this.#drag = { mark, from, to: from, captured: this.#shown.captured };
      }
      event.preventDefault();
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!this.#pointers.has(event.pointerId)) return;
      const at = this.#at(event);
      this.#pointers.set(event.pointerId, at);
      if (this.#pinch) this.#movePinch();
      else if (this.#drag?.pan) {
        this.view.panBy([at[0] - this.#drag.pan[0], at[1] - this.#drag.pan[1]]);
        this.#drag.pan = at;
      } else if (this.#drag) this.#drag.to = this.view.toPicture(at);
      this.redraw();
    });
    const end = (event, isDone) => {
      if (!this.#pointers.delete(event.pointerId)) return;
      const drag = this.#drag;
      if (this.#pinch) {
        if (this.#pointers.size === 0) this.#pinch = null;
      } else if (drag?.mark) {
        const isMoved = this.#isMoved(drag);
        const detail = { mark: drag.mark, id: drag.mark.id, at: drag.to, captured_ns: drag.captured };
        // While it is dragged the picture goes on: the mark is on the newest one. A tap is on the mark as it
        // was shown.
        if (isDone && isMoved) this.dispatchEvent(new CustomEvent("move-mark", { detail: { ...detail, captured_ns: this.#shown.captured } }));
        else if (isDone) this.dispatchEvent(new CustomEvent("tap-mark", { detail }));
      } else if (drag?.from) {
        // After the end of the freeze, the box was finished on the newest picture.
        const captured = this.isFrozen ? drag.captured : this.#shown.captured;
        this.unfreeze();
        if (isDone && this.isMarking) this.#mark(drag.to, captured);
        else if (isDone && !this.#isMoved(drag)) this.#tap(drag);
        else if (isDone) this.#select(boxBetween(drag.from, drag.to, this.view.picture), captured);
      }
      this.#drag = null;
      this.redraw();
    };
    canvas.addEventListener("pointerup", (event) => end(event, true));
    canvas.addEventListener("pointercancel", (event) => end(event, false));
    canvas.addEventListener("wheel", (event) => {
      // With Shift it is the camera's.
      if (!this.#shown || event.shiftKey) return;
      this.view.zoomBy(Math.exp(-event.deltaY / 400), this.#at(event));
      this.redraw();
      event.preventDefault();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.#onKey(event));
  }

  #beginPinch() {
    const [a, b] = [...this.#pointers.values()];
    [this.#drag, this.#pinch] = [null, { a, b }];
    if (this.isFrozen) this.unfreeze();
  }

  #movePinch() {
    const [a, b] = [...this.#pointers.values()];
    if (!a || !b || !this.view.picture) return;
    const before = this.#pinch;
    const middle = (p, q) => [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2];
    const distance = (p, q) => Math.max(1, Math.hypot(p[0] - q[0], p[1] - q[1]));
    const [from, to] = [middle(before.a, before.b), middle(a, b)];
    this.view.panBy([to[0] - from[0], to[1] - from[1]]);
    this.view.zoomBy(distance(a, b) / distance(before.a, before.b), to);
    this.#pinch = { a, b };
  }

  /** A box by keyboard, on the live picture. */
  #onKey(event) {
    if (!this.#shown || !this.view.picture || this.isWatchedOnly) return;
    const box = this.#keyBox;
    const stepped = box && steppedBox(box, event.key, event.shiftKey, this.view.picture);
    if (event.key === "Enter" && !box) {
      this.#keyBox = firstBox(this.view.picture, this.#shown.snapshot?.track.centre, this.isMarking);
    } else if (event.key === "Enter") {
      this.#keyBox = null;
      if (this.isMarking) this.#mark([box[0] + box[2] / 2, box[1] + box[3] / 2], this.#shown.captured);
      else this.#select(box, this.#shown.captured);
    } else if (event.key === "Escape" && (box || this.isMarking)) this.setMarking(false);
    else if (stepped) this.#keyBox = stepped;
    else return;
    event.preventDefault();
    event.stopPropagation();
    this.redraw();
  }

  zoomBy(factor) {
    if (!this.#shown) return;
    this.view.zoomBy(factor, [this.#canvas.width / 2, this.#canvas.height / 2]);
    this.redraw();
  }

  resetZoom() {
    this.view.reset();
    this.redraw();
  }

  /** The label beside the box; set by the page. */
  label = () => "";

  redraw() {
    const canvas = this.#canvas;
    const unit = window.devicePixelRatio || 1;
    const size = [Math.max(1, Math.round(canvas.clientWidth * unit)), Math.max(1, Math.round(canvas.clientHeight * unit))];
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    const pen = this.#pen;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.fillStyle = "#05090c";
    pen.fillRect(0, 0, ...size);
    if (!this.#shown) return;
    const picture = [this.#picture.width, this.#picture.height];
    this.view.fit(picture, size);
    const [x, y] = this.view.toCanvas([0, 0]);
    pen.imageSmoothingEnabled = this.view.scale < 3;
    pen.drawImage(this.#picture, x, y, picture[0] * this.view.scale, picture[1] * this.view.scale);
    const { snapshot } = this.#shown;
    const { trail, layers, isCalm, chosenMark } = this;
    if (snapshot) drawOverlay(pen, this.view, snapshot, { trail, layers, isCalm, chosenMark, label: this.label(snapshot), unit });
    if (this.#proposal && !this.isWatchedOnly) drawProposal(pen, this.view, this.#proposal, unit);
    if (this.#drag?.mark) ringOfMark(pen, this.view.toCanvas(this.#drag.to), unit);
    const isDrawing = this.#drag?.from && !this.#drag.mark && !this.isMarking;
    const box = this.#keyBox ?? (isDrawing ? boxBetween(this.#drag.from, this.#drag.to, picture) : this.kept);
    if (box) {
      const corner = this.view.toCanvas([box[0], box[1]]);
      pen.setLineDash([8 * unit, 5 * unit]);
      for (const [colour, width] of [["#000", 5], ["#fff", 2.5]]) {
        [pen.strokeStyle, pen.lineWidth] = [colour, width * unit];
        pen.strokeRect(...corner, box[2] * this.view.scale, box[3] * this.view.scale);
      }
      pen.setLineDash([]);
    }
  }
}
