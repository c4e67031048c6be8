// Buttons and keys that are held: turning and zooming the camera by hand, and driving the boat.

import { HeldDirections } from "./held.js";

/** How long one turn of the wheel holds. */
const WHEEL_MS = 200;

/** Sends a request again and again while a direction is held and may be, and once more at the end. */
export class HeldControl {
  #held = new HeldDirections();
  #timer = 0;
  #wheelTimer = 0;

  /**
   * @param {object} options
   * @param {Record<string, string>} options.keys direction by key
   * @param {string} options.buttons prefix of the buttons' ids
   * @param {string[]} [options.directions] those that have a button
   * @param {number} options.everyMs
   * @param {() => boolean} options.mayStart
   * @param {(axes: number[]) => void} options.send
   */
  constructor({ keys, buttons, directions = ["up", "down", "left", "right"], everyMs, mayStart, send }) {
    Object.assign(this, { keys, directions, everyMs, mayStart, send });
    for (const direction of directions) {
      const button = document.getElementById(`${buttons}-${direction}`);
      button.addEventListener("pointerdown", (event) => {
        if (event.button !== 0) return;
        button.setPointerCapture(event.pointerId);
        this.#set(direction, event.pointerId, true);
        event.preventDefault();
      });
      for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
        button.addEventListener(end, (event) => this.#set(direction, event.pointerId, false));
      }
      // A menu would take the release of the button: the hold would go on with nothing held.
      button.addEventListener("contextmenu", (event) => event.preventDefault());
      button.addEventListener("pointermove", (event) => event.buttons === 0 && this.#set(direction, event.pointerId, false));
      button.addEventListener("keydown", (event) => {
        if (event.key !== "Enter") return;
        if (!event.repeat) this.#set(direction, "Enter", true);
        event.preventDefault();
      });
      button.addEventListener("keyup", (event) => event.key === "Enter" && this.#set(direction, "Enter", false));
      button.addEventListener("blur", () => this.#set(direction, "Enter", false));
    }
    addEventListener("blur", () => this.release());
    document.addEventListener("visibilitychange", () => document.hidden && this.release());
  }

  /** A key went down or up. Returns whether it is one of this control's. */
  onKey(key, isDown) {
    const direction = this.keys[key];
    if (!direction) return false;
    this.#set(direction, key, isDown);
    return true;
  }

  /** Holds a direction for a short time, as a turn of the wheel does. */
  holdBriefly(direction) {
    clearTimeout(this.#wheelTimer);
    for (const other of this.directions) if (other !== direction) this.#set(other, "wheel", false);
    this.#set(direction, "wheel", true);
    this.#wheelTimer = setTimeout(() => this.#set(direction, "wheel", false), WHEEL_MS);
  }

  /** Everything is let go: what is still down holds nothing until it is pressed anew. */
  release() {
    if (this.#held.release()) this.#apply();
  }

  #set(direction, by, isHeld) {
    if (isHeld && !this.#held.isHeld && !this.mayStart()) return;
    if (this.#held.hold(direction, by, isHeld)) this.#apply();
  }

  #apply() {
    clearInterval(this.#timer);
    this.send(this.#held.axes);
    if (this.#held.isHeld) this.#timer = setInterval(() => this.#renew(), this.everyMs);
  }

  /** What may not start may not go on: the requests would be refused one after the other. */
  #renew() {
    if (this.mayStart()) this.send(this.#held.axes);
    else this.release();
  }
}
