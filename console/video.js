// Video: chooses the codec of the stream or JPEG, and pairs each picture with the snapshot that belongs to
// it.

import { Percentiles } from "./clock.js";
import { UnitDecoder, isWebCodecsPossible } from "./decoder.js";
import { SnapshotHistory } from "./snapshot_history.js";
import { H264, H265, JPEG, readVideoMessage } from "./video_message.js";

/** A picture waits this long for its snapshot, ms. */
const WAIT_MS = 50;

export class Video extends EventTarget {
  path = "none";
  /** The video that is shown: `first` or `second`. */
  shown = "first";
  #isJpegAsked = new URLSearchParams(location.search).get("video") === "jpeg" || !isWebCodecsPossible();
  /** Codecs that this browser does not decode. */
  #refused = new Set();
  #waiting = [];
  #snapshot = null;
  #history = new SnapshotHistory();
  #snapshotAt = 0;
  #delay = new Percentiles();
  /** Time of capture of the drawn picture, ns, and their number. */
  captured = 0;
  drawn = 0;
  /** When a picture was drawn last, ms of the page; null before the first. @type {number | null} */
  drawnAt = null;

  /** @param {import("./link.js").Link} link @param {(image: any, quarters: number, snapshot: object) => void} draw */
  constructor(link, draw) {
    super();
    [this.link, this.draw] = [link, draw];
    this.decoder = new UnitDecoder((frame, captured, quarters) => this.#add(frame, captured, quarters), () => {
      this.#refused.add(this.path);
      this.#choose();
    });
    link.addEventListener("video", ({ detail }) => this.#onMessage(detail));
    link.addEventListener("snapshot", ({ detail }) => {
      [this.#snapshot, this.#snapshotAt] = [detail, performance.now()];
      this.#history.add(detail);
      this.#choose();
      this.#flush();
    });
    setInterval(() => this.#flush(), WAIT_MS / 2);
  }

  /** Median and 95th percentile of the time from capture to drawing, ms; null where they are not known. */
  get delay() {
    return this.#delay.get();
  }

  /** The time of the session: the program's clock, or that of a simulated world, which may be slower or stand still. */
  #sessionMs(now) {
    const drive = this.#snapshot?.drive;
    if (!drive) return this.link.clock.programMs(now);
    return this.#snapshot.at_ns / 1e6 + (now - this.#snapshotAt) * (drive.paused ? 0 : drive.pace);
  }

  /** Shows this video from now on. */
  show(number) {
    if (number === this.shown) return;
    [this.shown, this.path, this.drawnAt] = [number, "none", null];
    for (const picture of this.#waiting.splice(0)) picture.image.close();
    this.decoder.close();
    this.#delay = new Percentiles();
    this.#choose();
  }

  /** The state of the video that is shown; null where there is no such video. */
  get source() {
    const { video, other_video: other } = this.#snapshot ?? {};
    return video?.number === this.shown ? video : (other ?? null);
  }

  #choose() {
    if (!this.#snapshot) return;
    const codec = this.source?.codec;
    const path = codec && !this.#isJpegAsked && !this.#refused.has(codec) ? codec : "jpeg";
    if (path === this.path) return;
    this.path = path;
    this.link.chooseVideo({ path, video: this.shown });
  }

  async #onMessage(message) {
    const unit = readVideoMessage(message);
    if (!unit) return;
    if ((unit.kind === H264 && this.path === "h264") || (unit.kind === H265 && this.path === "h265")) {
      this.decoder.decode(unit);
    } else if (unit.kind === JPEG && this.path === "jpeg") {
      const image = await createImageBitmap(new Blob([unit.payload], { type: "image/jpeg" })).catch(() => null);
      if (image) this.#add(image, unit.captured, 0);
    }
  }

  #add(image, captured, quarters) {
    this.#waiting.push({ image, captured, quarters, at: performance.now() });
    this.#flush();
  }

  /** Draws the newest picture whose snapshot has come, or that has waited long enough. */
  #flush() {
    const now = performance.now();
    const isTracked = this.#snapshot?.video.number === this.shown;
    const processed = isTracked ? (this.#snapshot?.video.captured_ns ?? 0) : Infinity;
    let ready = -1;
    this.#waiting.forEach((picture, index) => {
      if (picture.captured <= processed || now - picture.at >= WAIT_MS) ready = index;
    });
    if (ready < 0) return;
    const passed = this.#waiting.splice(0, ready + 1);
    const { image, captured, quarters } = passed[ready];
    const snapshot = isTracked ? (this.#history.of(captured) ?? this.#snapshot) : null;
    this.draw(image, quarters, { captured, snapshot });
    for (const picture of passed) picture.image.close();
    const programMs = this.#sessionMs(now);
    if (programMs !== null) this.#delay.add(now, programMs - captured / 1e6);
    [this.captured, this.drawn, this.drawnAt] = [captured, this.drawn + 1, now];
    this.dispatchEvent(new Event("drawn"));
  }
}
