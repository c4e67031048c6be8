// Stop: sent at once, and repeated until the program has taken it.

const REPEAT_MS = 100;
const ALARM_MS = 1000;

/** When Stop is repeated, and when its acknowledgement is overdue. Pure. */
export class StopRepeater {
  #since = null;
  #before = 0;

  /** Stop was pressed; `taken`: stops that the program had taken. */
  press(nowMs, taken) {
    if (this.#since === null) [this.#since, this.#before] = [nowMs, taken];
  }

  /** The program has taken `taken` stops. */
  onTaken(taken) {
    if (taken > this.#before) this.#since = null;
  }

  /** An answer `accepted` to a stop. */
  onAccepted() {
    this.#since = null;
  }

  get isPending() {
    return this.#since !== null;
  }

  isOverdue(nowMs) {
    return this.#since !== null && nowMs - this.#since > ALARM_MS;
  }
}

/** Sends Stop over the socket and, where that is closed, by a request of its own. */
export class Stopper extends EventTarget {
  #repeater = new StopRepeater();
  #timer = 0;
  #taken = 0;

  constructor(link) {
    super();
    this.link = link;
    link.addEventListener("snapshot", ({ detail }) => {
      if (detail.stops_taken < this.#taken) this.#repeater = new StopRepeater();
      this.#taken = detail.stops_taken;
      this.#repeater.onTaken(detail.stops_taken);
      this.#update();
    });
  }

  get isPending() {
    return this.#repeater.isPending;
  }

  get isOverdue() {
    return this.#repeater.isOverdue(performance.now());
  }

  press() {
    this.#repeater.press(performance.now(), this.#taken);
    this.#send();
    clearInterval(this.#timer);
    this.#timer = setInterval(() => this.#send(), REPEAT_MS);
    this.#update();
  }

  async #send() {
    if (!this.#repeater.isPending) return this.#update();
    const request = { kind: "stop" };
    if (!this.link.isUp) {
      const body = JSON.stringify({ request });
      const headers = { "Content-Type": "application/json" };
      fetch("/api/v1/requests", { method: "POST", headers, body })
        .then((response) => response.json())
        .then((answer) => answer.answer === "accepted" && this.#accept())
        .catch(() => {});
    }
    const answer = await this.link.request(request);
    if (answer.answer === "accepted") this.#accept();
    this.#update();
  }

  #accept() {
    this.#repeater.onAccepted();
    this.#update();
  }

  #update() {
    if (!this.#repeater.isPending) clearInterval(this.#timer);
    this.dispatchEvent(new Event("change"));
  }
}
