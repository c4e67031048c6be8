// A gamepad steers the boat: the left stick, ahead and astern, left and right.

/** Smaller deflections are rest. */
const DEAD_ZONE = 0.15;

const axis = (value) => (Math.abs(value) < DEAD_ZONE ? 0 : value);

/** Sends the deflection of the left stick while there is one, and once more when it is let go. */
export class GamepadHelm {
  #isHeld = false;
  /** Whether the stick was at rest since the page may steer: a stick that is held over, or a pad that lies on it, moves nothing. */
  #wasAtRest = false;

  /** @param {{mayStart: () => boolean, send: (axes: number[]) => void}} options `send` takes right and ahead, -1 to 1 */
  constructor({ mayStart, send }) {
    Object.assign(this, { mayStart, send });
  }

  /** To be called some times a second. */
  tick() {
    // Of other devices (pedals, throttles) nothing says which axis is which, and where it rests.
    const pad = (navigator.getGamepads?.() ?? []).find((found) => found?.connected && found.mapping === "standard");
    const maySteer = pad !== undefined && document.hasFocus() && !document.hidden && this.mayStart();
    const [right, ahead] = pad ? [axis(pad.axes[0]), -axis(pad.axes[1])] : [0, 0];
    const isAtRest = right === 0 && ahead === 0;
    this.#wasAtRest = maySteer && (this.#wasAtRest || isAtRest);
    const isHeld = this.#wasAtRest && !isAtRest;
    if (isHeld) this.send([right, ahead]);
    else if (this.#isHeld) this.send([0, 0]);
    this.#isHeld = isHeld;
  }
}
