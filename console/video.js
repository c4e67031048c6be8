// Video: chooses the codec of the stream or JPEG, and pairs each picture with the snapshot that belongs to
// it.

import { Percentiles } from "./clock.js";
import { UnitDecoder, isWebCodecsPossible } from "./decoder.js";
import { SnapshotHistory } from "./snapshot_history.js";
import { H264, H265, JPEG, readVideoMessage } from "./video_message.js";

/** A picture waits this long for its snapshot, ms. */
const WAIT_MS = 50;
/** A decoder that is behind by so much skips to the next key frame, ms. */
const SKIP_MS = 1000;
/** A decoder that has the group of pictures before the page's begin to catch up with may take so long, ms. */
const CATCH_UP_MS = 5000;
/** So many skips within this time, ms: the browser or the network is too slow for the stream. */
const [MAX_SKIPS, SKIP_WINDOW_MS] = [3, 60_000];

/** Whether the program made a picture smaller before the boat was looked for: boxes are in its pixels. */
function isOfOtherSize(image, quarters, size) {
  const { width, height } = image.visibleRect ?? image;
  const drawn = quarters % 2 === 1 ? height : width;
  return size !== null && Math.abs(drawn - size[0]) > 0.01 * size[0];
}

export class Video {
  path = "none";
  /** The video that is shown: `first` or `second`. */
  shown = "first";
  #isJpegAsked = new URLSearchParams(location.search).get("video") === "jpeg" || !isWebCodecsPossible();
  /** Codecs that this browser does not decode. */
  #refused = new Set();
  /** When pictures were left out because the page was too slow, ms of the page. */
  #skips = [];
  #hasCaughtUp = false;
  /** The unit that came last. @type {any} */
  #last = null;
  /** The JPEG picture that comes after the one that is being decoded. */
  #nextJpeg = null;
  #isJpegDecoding = false;
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
  /** From the arrival of the drawn picture to its drawing, ms. */
  lagMs = 0;

  /** @param {import("./link.js").Link} link @param {(image: any, quarters: number, snapshot: object) => void} draw */
  constructor(link, draw) {
    [this.link, this.draw] = [link, draw];
    this.decoder = new UnitDecoder((frame, unit) => this.#add(frame, unit), () => this.#refusePath());
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
    this.#nextJpeg = null;
    this.decoder.skip();
    [this.#delay, this.lagMs] = [new Percentiles(), 0];
    this.#choose();
  }

  /** The state of the video that is shown; null where there is no such video. */
  get source() {
    const { video, other_video: other } = this.#snapshot ?? {};
    return video?.number === this.shown ? video : (other ?? null);
  }

  /** Takes JPEG instead of the codec. */
  #refusePath() {
    this.#refused.add(this.path);
    this.#choose();
  }

  #choose() {
    if (!this.#snapshot) return;
    const codec = this.source?.codec;
    const path = codec && !this.#isJpegAsked && !this.#refused.has(codec) ? codec : "jpeg";
    if (path === this.path) return;
    [this.path, this.#last, this.#hasCaughtUp] = [path, null, false];
    this.link.chooseVideo({ path, video: this.shown });
  }

  #onMessage(message) {
    const unit = readVideoMessage(message);
    // Of the other video: it was under way when the page asked for this one.
    if (!unit || unit.video !== this.shown) return;
    const arrived = { ...unit, at: performance.now() };
    if ((unit.kind === H264 && this.path === "h264") || (unit.kind === H265 && this.path === "h265")) {
      this.#decode(arrived);
    } else if (unit.kind === JPEG && this.path === "jpeg") {
      this.#nextJpeg = arrived;
      this.#decodeJpegs();
    }
  }

  /** Decodes a unit, unless the page is too slow for the stream. */
  #decode(unit) {
    const waitsMs = unit.at - (this.decoder.waiting?.at ?? unit.at);
    this.#hasCaughtUp ||= this.#last !== null && waitsMs < SKIP_MS / 4;
    const isLate = waitsMs > (this.#hasCaughtUp ? SKIP_MS : CATCH_UP_MS);
    if (isLate) this.decoder.skip();
    // The program leaves units out of what it sends to a page that does not handle them in time.
    const hasGap = this.#last?.epoch === unit.epoch && this.#last.index + 1 !== unit.index;
    this.#last = unit;
    if (isLate || hasGap) {
      this.#skips = [...this.#skips.filter((at) => unit.at - at < SKIP_WINDOW_MS), unit.at];
      if (this.#skips.length >= MAX_SKIPS) return this.#refusePath();
    }
    this.decoder.decode(unit);
  }

  /** Decodes the newest picture, one after the other: those that came meanwhile are left out. */
  async #decodeJpegs() {
    if (this.#isJpegDecoding) return;
    this.#isJpegDecoding = true;
    while (this.#nextJpeg) {
      const picture = this.#nextJpeg;
      this.#nextJpeg = null;
      const image = await createImageBitmap(new Blob([picture.payload], { type: "image/jpeg" })).catch(() => null);
      if (image && picture.video === this.shown) this.#add(image, picture);
    }
    this.#isJpegDecoding = false;
  }

  #add(image, { captured, quarters, at: arrivedAt }) {
    this.#waiting.push({ image, captured, quarters, arrivedAt, at: performance.now() });
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
    const { image, captured, quarters, arrivedAt } = passed[ready];
    const snapshot = isTracked ? (this.#history.of(captured) ?? this.#snapshot) : null;
    const isOwn = this.path !== "jpeg" && snapshot?.video.captured_ns === captured;
    if (isOwn && isOfOtherSize(image, quarters, snapshot.video.size)) {
      for (const picture of passed) picture.image.close();
      return this.#refusePath();
    }
    this.draw(image, quarters, { captured, snapshot });
    for (const picture of passed) picture.image.close();
    const programMs = this.#sessionMs(now);
    if (programMs !== null) this.#delay.add(now, programMs - captured / 1e6);
    [this.captured, this.drawn, this.drawnAt, this.lagMs] = [captured, this.drawn + 1, now, now - arrivedAt];
  }
}
