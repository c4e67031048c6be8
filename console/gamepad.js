// A gamepad steers the boat: the left stick, ahead and astern, left and right.

/** Smaller deflections are rest. */
const DEAD_ZONE = 0.15;

const axis = (value) => (Math.abs(value) < DEAD_ZONE ? 0 : value);

/** Sends the deflection of the left stick while there is one, and once more when it is let go. */
export class GamepadHelm {
  #isHeld = false;

  /** @param {{mayStart: () => boolean, send: (axes: number[]) => void}} options `send` takes right and ahead, -1 to 1 */
  constructor({ mayStart, send }) {
    Object.assign(this, { mayStart, send });
  }

  /** To be called some times a second. */
  tick() {
    const pad = (navigator.getGamepads?.() ?? []).find((found) => found?.connected && found.axes.length >= 2);
    const [right, ahead] = pad && document.hasFocus() && !document.hidden ? [axis(pad.axes[0]), -axis(pad.axes[1])] : [0, 0];
    const isHeld = right !== 0 || ahead !== 0;
    if (isHeld && this.mayStart()) this.send([right, ahead]);
    else if (this.#isHeld) this.send([0, 0]);
    this.#isHeld = isHeld;
  }
}
