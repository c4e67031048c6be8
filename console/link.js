// The socket to the program: messages in both directions, reconnection, and the answers to requests.

import { mayEnter, pageName } from "./access.js";
import { ProgramClock } from "./clock.js";

const STALE_MS = 1500;
/** How often the page shows that it lives, and says what it has handled, ms. */
const PING_MS = 200;
/** Shortest time between two pings that say that video was handled, ms. */
const VIDEO_PING_MS = 20;
/** A socket that was silent for so long is given up, and a new one is opened. */
const GIVEN_UP_MS = 3 * STALE_MS;
const LONGEST_WAIT_MS = 2000;
/** Requests that end a motion: they are right also when they come late. */
const ENDING = new Set(["stop", "stop-vessel", "disengage"]);
/** Requests that set something in motion that goes on by itself. */
const BEGINNING = new Set(["engage", "search", "guide", "go-home"]);
/** The program closes the socket with this code where too many pages are open. */
const TRY_AGAIN_LATER = 1013;
/** The program closes the socket with this code at its end. */
const GOING_AWAY = 1001;
/** How the reason then begins; what may still move follows. */
const FAREWELL = "the program ends";

export class Link extends EventTarget {
  #socket = null;
  #nextId = 1;
  #waiting = new Map();
  #wait = 250;
  #heard = 0;
  /** The video that is asked for. @type {{path: string, video: string}} */
  #video = { path: "none", video: "first" };
  /** Snapshots and video messages that this connection has brought. */
  #handled = 0;
  /** How many stops the newest snapshot of this connection tells of; `undefined`: there is none yet. */
  #stops = undefined;
  /** When the pings were sent that are not answered, ms of the page; oldest first. */
  #unanswered = [];
  #trip = 0;
  #pingedAt = 0;
  #isPinging = false;
  isUp = false;
  /** Whether the page was connected before. */
  wasUp = false;
  /** Whether the program said that it ends. */
  isEnded = false;
  /** What may still move after its end. */
  left = { camera: false, boat: false };
  /** Whether the program closed the connection because too many pages are open. */
  isDismissed = false;
  clock = new ProgramClock();

  /** Connects, and reconnects for ever. */
  start() {
    this.#connect();
    setInterval(() => this.#watch(), 250);
    setInterval(() => this.#ping(), PING_MS);
  }

  /** By how much what the page receives is late at the most, ms: the last round trip, or the one that still goes on. */
  behindMs(nowMs) {
    return this.isUp ? Math.max(this.#trip, nowMs - (this.#unanswered[0] ?? nowMs)) : 0;
  }

  #connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/api/v1/socket?client=${pageName}`);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#heard = performance.now();
    socket.onopen = () => {
      this.#wait = 250;
      this.clock.reset();
      [this.#handled, this.#stops, this.#trip, this.#unanswered] = [0, undefined, 0, []];
      this.#send({ type: "video", ...this.#video });
      this.#ping();
    };
    socket.onmessage = (event) => {
      if (socket !== this.#socket) return;
      this.#heard = performance.now();
      if (!this.isUp) this.#setUp(true);
      if (event.data instanceof ArrayBuffer) this.#onVideo(event.data);
      else this.#onText(JSON.parse(event.data));
    };
    socket.onclose = ({ code, reason }) => {
      if (socket !== this.#socket) return;
      this.isDismissed = code === TRY_AGAIN_LATER;
      // What is between page and program closes connections with this code, too.
      const isFarewell = code === GOING_AWAY && reason.startsWith(FAREWELL);
      if (isFarewell) this.left = { camera: reason.includes("camera"), boat: reason.includes("boat") };
      this.isEnded = isFarewell || (this.isEnded && !this.isUp);
      this.#setUp(false);
      this.#socket = null;
      if (!this.isDismissed) this.#retry();
    };
  }

  /** Connects again after a while, unless the program refuses the page. */
  #retry() {
    setTimeout(async () => {
      if ((await mayEnter()) === false) this.dispatchEvent(new Event("refused"));
      else this.#connect();
    }, this.#wait);
    this.#wait = Math.min(2 * this.#wait, LONGEST_WAIT_MS);
  }

  #setUp(isUp) {
    if (this.isUp === isUp) return;
    this.isUp = isUp;
    if (isUp) [this.wasUp, this.isEnded] = [true, false];
    else this.#endWaiting();
    this.dispatchEvent(new CustomEvent("up", { detail: isUp }));
  }

  /** No answer comes any more to what was sent: it may have been done, or may still be. */
  #endWaiting() {
    for (const resolve of this.#waiting.values()) resolve({ answer: "refused", reason: null, unanswered: true });
    this.#waiting.clear();
  }

  /** A socket that is open but silent counts as lost. */
  #watch() {
    const socket = this.#socket;
    const silence = performance.now() - this.#heard;
    if (!socket || silence <= STALE_MS) return;
    this.#setUp(false);
    if (silence <= GIVEN_UP_MS) return;
    // A peer that is gone does not answer the closing handshake, and the browser waits a minute for it:
    // `onclose` is not waited for, and ignores this socket from now on.
    this.#socket = null;
    socket.close();
    this.#endWaiting();
    this.#retry();
  }

  #ping() {
    this.#pingedAt = performance.now();
    const isSent = this.#send({ type: "ping", sent_ms: this.#pingedAt, handled: this.#handled });
    if (isSent) this.#unanswered.push(this.#pingedAt);
  }

  #onVideo(message) {
    this.dispatchEvent(new CustomEvent("video", { detail: message }));
    this.#handled += 1;
    if (this.#isPinging) return;
    this.#isPinging = true;
    setTimeout(() => {
      this.#isPinging = false;
      this.#ping();
    }, this.#pingedAt + VIDEO_PING_MS - performance.now());
  }

  #onPong({ sent_ms: pingedAt, now_ns: programNs, sent }) {
    const now = performance.now();
    this.clock.add(pingedAt, now, programNs);
    this.#trip = now - pingedAt;
    this.#unanswered = this.#unanswered.filter((other) => other > pingedAt);
    // All that was sent before has come, and is handled: the count cannot drift.
    this.#handled = sent;
  }

  #onText(message) {
    if (message.type === "snapshot") {
      this.#handled += 1;
      this.#stops = message.stops_taken;
    }
    if (message.type === "pong") {
      this.#onPong(message);
    } else if (message.type === "answer") {
      this.#waiting.get(message.id)?.(message);
      this.#waiting.delete(message.id);
    }
    this.dispatchEvent(new CustomEvent(message.type, { detail: message }));
  }

  #send(message) {
    if (this.#socket?.readyState !== WebSocket.OPEN) return false;
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  /**
   * Makes a request. The promise gives its answer: `unsent` where nothing was sent, `unanswered` where the connection was lost
   * before the answer. Into a silent socket only what ends a motion is sent: the rest would be done when the operator has gone on.
   */
  request(request) {
    const id = this.#nextId++;
    return new Promise((resolve) => {
      // What the camera or the boat goes on with waits for the first snapshot: its stops are known then.
      const isKnown = this.#stops !== undefined || !BEGINNING.has(request.kind);
      const maySend = (this.isUp && isKnown) || ENDING.has(request.kind);
      const isSent = maySend && this.#send({ type: "request", id, request, stops_taken: this.#stops });
      if (!isSent) return resolve({ answer: "refused", reason: null, unsent: true });
      this.#waiting.set(id, resolve);
    });
  }

  /** Chooses which video is sent, and how. @param {{path: string, video: string}} wanted */
  chooseVideo(wanted) {
    this.#video = wanted;
    this.#send({ type: "video", ...wanted });
  }
}
