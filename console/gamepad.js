// A gamepad: the left stick steers the boat, ahead and astern, left and right; the right stick zooms the camera, up closer.

/** Smaller deflections are rest. */
const DEAD_ZONE = 0.15;

const axis = (value) => (Math.abs(value) < DEAD_ZONE ? 0 : value);

/** Sends the deflection of a stick while there is one, and once more when it is let go. */
export class GamepadStick {
  #isHeld = false;
  /** Whether the stick was at rest since the page may steer: a stick that is held over, or a pad that lies on it, moves nothing. */
  #wasAtRest = false;

  /** @param {{axes: number[], mayStart: () => boolean, send: (axes: number[]) => void}} options `axes`: those of the stick; `send`
   * takes right and up, -1 to 1 */
  constructor({ axes, mayStart, send }) {
    Object.assign(this, { axes, mayStart, send });
  }

  /** The stick moves nothing until it was at rest. */
  release() {
    if (this.#isHeld) this.send([0, 0]);
    this.#isHeld = this.#wasAtRest = false;
  }

  /** To be called some times a second. */
  tick() {
    // Of other devices (pedals, throttles) nothing says which axis is which, and where it rests.
    const pad = (navigator.getGamepads?.() ?? []).find((found) => found?.connected && found.mapping === "standard");
    const maySteer = pad !== undefined && document.hasFocus() && !document.hidden && this.mayStart();
    const [across, along] = this.axes;
    const [right, up] = pad ? [axis(pad.axes[across]), 0 - axis(pad.axes[along])] : [0, 0];
    const isAtRest = right === 0 && up === 0;
    this.#wasAtRest = maySteer && (this.#wasAtRest || isAtRest);
    const isHeld = this.#wasAtRest && !isAtRest;
    if (isHeld) this.send([right, up]);
    else if (this.#isHeld) this.send([0, 0]);
    this.#isHeld = isHeld;
  }
}
