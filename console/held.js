// Held directions: what is held by keys and buttons, and when it has to be renewed. Pure.

/** Directions that are held, by any number of keys and buttons. */
export class HeldDirections {
  #held = new Map();

  /** A key or button (`by`) begins or ends to hold a direction. Returns whether that changed anything. */
  hold(direction, by, isHeld) {
    const holders = this.#held.get(direction) ?? new Set();
    if (holders.has(by) === isHeld) return false;
    if (isHeld) holders.add(by);
    else holders.delete(by);
    this.#held.set(direction, holders);
    return true;
  }

  /** Everything is let go. Returns whether anything was held. */
  release() {
    const was = this.isHeld;
    this.#held.clear();
    return was;
  }

  get isHeld() {
    return [...this.#held.values()].some((holders) => holders.size > 0);
  }

  is(direction) {
    return (this.#held.get(direction)?.size ?? 0) > 0;
  }

  /** Both axes, -1 to 1: right less left, up less down. */
  get axes() {
    const axis = (plus, minus) => Number(this.is(plus)) - Number(this.is(minus));
    return [axis("right", "left"), axis("up", "down")];
  }
}
