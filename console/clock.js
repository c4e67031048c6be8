// The program's time in the page: from pings, by the one with the shortest round trip.

/** Maps the page's time (ms) to the program's (ns). */
export class ProgramClock {
  #samples = [];

  /** Adds a pong: when the ping was sent and the pong received, ms, and the program's time, ns. */
  add(sentMs, receivedMs, nowNs) {
    this.#samples.push({ trip: receivedMs - sentMs, offset: nowNs / 1e6 - (sentMs + receivedMs) / 2 });
    if (this.#samples.length > 20) this.#samples.shift();
  }

  /** The program's time in ms at a time of the page; null before the first pong. */
  programMs(pageMs) {
    if (!this.#samples.length) return null;
    const best = this.#samples.reduce((a, b) => (b.trip < a.trip ? b : a));
    return pageMs + best.offset;
  }

  /** Forgets all: the program's time was set. */
  reset() {
    this.#samples = [];
  }
}

/** Median and 95th percentile of the values of the last seconds. */
export class Percentiles {
  #values = [];

  constructor(windowMs = 5000) {
    this.windowMs = windowMs;
  }

  add(nowMs, value) {
    this.#values.push([nowMs, value]);
    while (this.#values.length && nowMs - this.#values[0][0] > this.windowMs) this.#values.shift();
  }

  /** @returns {{median: number, p95: number} | null} */
  get() {
    if (!this.#values.length) return null;
    const sorted = this.#values.map(([, value]) => value).sort((a, b) => a - b);
    const at = (share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
    return { median: at(0.5), p95: at(0.95) };
  }
}
