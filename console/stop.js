// Stop: sent at once, and repeated until the program has taken it.

const REPEAT_MS = 100;
const ALARM_MS = 1000;
/** A request of its own is given up after this time, so that none reaches the program long after it was made. */
const REQUEST_MS = 1000;

/** Which press of Stop is waiting for its acknowledgement, and whether that is overdue. Pure. */
export class StopRepeater {
  #since = null;
  #press = 0;

  /** Stop was pressed. Presses before the acknowledgement are one. */
  press(nowMs) {
    if (this.#since !== null) return;
    this.#since = nowMs;
    this.#press += 1;
  }

  /** The number of the newest press. */
  get number() {
    return this.#press;
  }

  /** An answer `accepted` to a stop that was sent for this press. (Stops of other pages, and answers to a press before, say nothing of it.) */
  onAccepted(press) {
    if (press === this.#press) this.#since = null;
  }

  get isPending() {
    return this.#since !== null;
  }

  isOverdue(nowMs) {
    return this.#since !== null && nowMs - this.#since > ALARM_MS;
  }
}

/** Sends Stop over the socket and, where that is closed or silent, by a request of its own. */
export class Stopper extends EventTarget {
  #repeater = new StopRepeater();
  #timer = 0;
  /** The press that was last sent over the socket. */
  #sent = 0;
  /** Ends the request that is under way; `null`: there is none. */
  #posting = null;

  constructor(link) {
    super();
    this.link = link;
  }

  get isPending() {
    return this.#repeater.isPending;
  }

  get isOverdue() {
    return this.#repeater.isOverdue(performance.now());
  }

  press() {
    this.#repeater.press(performance.now());
    this.#send();
    clearInterval(this.#timer);
    this.#timer = setInterval(() => this.#send(), REPEAT_MS);
    this.#update();
  }

  async #send() {
    if (!this.#repeater.isPending) return this.#update();
    const { number } = this.#repeater;
    if (!this.link.isUp && this.#posting === null) this.#post(number);
    // A silent socket delivers what it was given, if ever: once is enough.
    if (this.link.isUp || this.#sent !== number) {
      this.#sent = number;
      const answer = await this.link.request({ kind: "stop" });
      if (answer.answer === "accepted") this.#accept(number);
    }
    this.#update();
  }

  /** One request at a time: what waits in the browser would arrive after the operator has gone on. */
  async #post(number) {
    const posting = new AbortController();
    this.#posting = posting;
    const tooLong = setTimeout(() => posting.abort(), REQUEST_MS);
    try {
      const headers = { "Content-Type": "application/json" };
      const body = JSON.stringify({ request: { kind: "stop" } });
      const response = await fetch("/api/v1/requests", { method: "POST", headers, body, signal: posting.signal });
      if ((await response.json()).answer === "accepted") this.#accept(number);
    } catch {
      // The next repetition makes another one.
    } finally {
      clearTimeout(tooLong);
      this.#posting = null;
    }
  }

  #accept(number) {
    this.#repeater.onAccepted(number);
    if (!this.#repeater.isPending) this.#posting?.abort();
    this.#update();
  }

  #update() {
    if (!this.#repeater.isPending) clearInterval(this.#timer);
    this.dispatchEvent(new Event("change"));
  }
}
