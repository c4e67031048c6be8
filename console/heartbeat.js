// Whether the program is heard and still decides, and how old the state is that the page shows. Pure.

/** The loop of a live run takes a turn every 0.2 s at least: one that has taken none for so long hangs, whatever else is still sent. */
const HANGS_MS = 1500;
/** What reaches the page so late is not what is now, ms. */
const BEHIND_MS = 1000;

export class Heartbeat {
  #beat = null;
  #beatAt = 0;
  #isResting = false;

  /** A snapshot came. */
  onSnapshot({ beat, drive }, nowMs) {
    if (beat !== this.#beat) this.#beatAt = nowMs;
    // A demo turns no real camera, and takes no turns while it is paused or loads a world.
    [this.#beat, this.#isResting] = [beat, Boolean(drive)];
    if (this.#isResting) this.#beatAt = nowMs;
  }

  /** The connection came up: what it says of the time before is no loss. */
  onUp(nowMs) {
    this.#beatAt = nowMs;
  }

  /**
   * @param {{isUp: boolean, isDismissed: boolean, isEnded: boolean, wasUp: boolean, behindMs: (nowMs: number) => number}} link
   * @returns {string | null} the key of a line in `words.losses`; null: all is well, or the page connects for the first time
   */
  loss(link, nowMs) {
    const { isUp, isDismissed, isEnded, wasUp } = link;
    if (!isUp) return isDismissed ? "dismissed" : isEnded ? "ended" : wasUp ? "lost" : null;
    if (link.behindMs(nowMs) > BEHIND_MS) return "behind";
    return this.#beat !== null && !this.#isResting && nowMs - this.#beatAt > HANGS_MS ? "hangs" : null;
  }

  /** Since when the state is the same, whole seconds. */
  ageS(nowMs) {
    return Math.floor((nowMs - this.#beatAt) / 1000);
  }
}
