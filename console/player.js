// Plays a recording: fetches its parts, decodes them as the time goes on, and shows each picture with what
// the pilot made of it.

import { UnitDecoder, isWebCodecsPossible } from "./decoder.js";
import { JPEG, readVideoMessage } from "./video_message.js";

/** So much is fetched ahead, and decoded ahead, ms of the recording at normal speed. */
const FETCH_MS = 2500;
const DECODE_MS = 200;
/** Kinds of the items of a part. */
const UNIT = 1;
const SCENE = 2;

/** The items of a part. */
function* itemsOf(buffer) {
  const view = new DataView(buffer);
  for (let at = 0; at + 5 <= buffer.byteLength; ) {
    const [length, kind] = [view.getUint32(at, true), view.getUint8(at + 4)];
    yield { kind, content: buffer.slice(at + 5, at + 5 + length) };
    at += 5 + length;
  }
}

export class Player extends EventTarget {
  /** The time that is shown, ms since the first step. */
  ms = 0;
  isPlaying = false;
  speed = 1;
  #place = "";
  #form = isWebCodecsPossible() ? "" : "?form=jpeg";
  /** Changes with each seek: what was asked for before it is dropped. */
  #generation = 0;
  #began = 0;
  #units = [];
  #fed = 0;
  #scenes = new Map();
  #pictures = [];
  /** Where the next part begins, ms; null: there is none. @type {number | null} */
  #next = null;
  #isLoading = false;
  #shown = -1;
  #lastTick = 0;
  #decoder;

  /** @param {(image: any, quarters: number, scene: any, ms: number) => void} draw Gets the time of the picture too. */
  constructor(draw) {
    super();
    this.draw = draw;
    this.#decoder = new UnitDecoder(
      (frame, { captured, quarters }) => this.#addPicture(frame, captured, quarters, this.#generation),
      () => {
        this.#form = "?form=jpeg";
        this.seek(this.ms);
      },
    );
    const tick = (now) => {
      this.#tick(now);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  /** Opens the recording at this address, at its begin; an empty address closes. */
  open(place) {
    [this.#place, this.isPlaying] = [place, false];
    this.seek(0);
  }

  play(isPlaying) {
    this.isPlaying = isPlaying && this.#place !== "";
  }

  seek(ms) {
    this.#generation += 1;
    for (const { image } of this.#pictures.splice(0)) image.close();
    this.#decoder.close();
    [this.ms, this.#units, this.#fed, this.#shown, this.#isLoading] = [Math.max(0, ms), [], 0, -1, false];
    this.#scenes.clear();
    this.#next = this.#place ? this.ms : null;
    this.#load();
  }

  /** Shows this time, as another player does. */
  follow(ms) {
    if (ms < this.ms || ms > this.ms + FETCH_MS) this.seek(ms);
    else this.ms = ms;
  }

  /** One picture on, or back. */
  step(direction) {
    this.play(false);
    const times = this.#units.map(({ ms }) => ms).sort((one, other) => one - other);
    // Before the first picture, that one is shown.
    const shown = Math.max(0, times.findLastIndex((time) => time <= this.ms));
    const at = times[shown + direction];
    if (direction > 0 && at !== undefined) this.ms = at;
    else this.seek(at ?? this.ms + direction * 34);
  }

  async #load() {
    if (this.#isLoading || this.#next === null) return;
    this.#isLoading = true;
    const generation = this.#generation;
    const response = await fetch(`${this.#place}/part/${Math.floor(this.#next)}${this.#form}`).catch(() => null);
    const answer = response?.ok ? await response.arrayBuffer() : null;
    if (generation !== this.#generation) return;
    this.#isLoading = false;
    if (!answer) {
      this.#next = null;
      this.play(false);
      this.dispatchEvent(new CustomEvent("refused", { detail: response ? await response.text() : null }));
      return;
    }
    const next = response.headers.get("X-Next-Ms");
    this.#next = next === null ? null : Number(next);
    this.#began = Number(response.headers.get("X-Began-Ns"));
    for (const { kind, content } of itemsOf(answer)) {
      if (kind === SCENE) this.#addScene(JSON.parse(new TextDecoder().decode(content)));
      const unit = kind === UNIT ? readVideoMessage(content) : null;
      if (unit) this.#units.push({ ...unit, ms: (unit.captured - this.#began) / 1e6 });
    }
  }

  #addScene(scene) {
    this.#scenes.set(scene.captured_ns, scene);
  }

  #addPicture(image, captured, quarters, generation) {
    if (generation !== this.#generation) return image.close();
    this.#pictures.push({ image, captured, quarters, ms: (captured - this.#began) / 1e6 });
    this.#pictures.sort((one, other) => one.ms - other.ms);
  }

  async #feed(unit) {
    if (unit.kind !== JPEG) return this.#decoder.decode(unit);
    const generation = this.#generation;
    const image = await createImageBitmap(new Blob([unit.payload], { type: "image/jpeg" })).catch(() => null);
    if (image) this.#addPicture(image, unit.captured, 0, generation);
  }

  #tick(now) {
    const passed = Math.min(250, now - this.#lastTick);
    this.#lastTick = now;
    if (!this.#place) return;
    const end = this.#units.at(-1)?.ms;
    if (this.isPlaying && end !== undefined) {
      this.ms = Math.min(this.ms + passed * this.speed, end);
      if (this.ms >= end && this.#next === null) this.play(false);
    }
    const ahead = Math.max(1, this.speed);
    // The video may begin later than the first step: its first picture is shown all the same.
    const isDue = ({ ms }) => this.#fed === 0 || ms <= this.ms + DECODE_MS * ahead;
    while (this.#fed < this.#units.length && isDue(this.#units[this.#fed])) {
      this.#feed(this.#units[this.#fed]);
      this.#fed += 1;
    }
    if ((end ?? 0) < this.ms + FETCH_MS * ahead) this.#load();
    this.#drop();
    this.#show();
  }

  /** Forgets what was shown a while ago. */
  #drop() {
    const old = this.#units.findIndex(({ ms }) => ms >= this.ms - FETCH_MS);
    if (old < 500) return;
    for (const { captured } of this.#units.splice(0, old)) this.#scenes.delete(captured);
    this.#fed -= old;
  }

  #show() {
    let ready = this.#pictures.findLastIndex(({ ms }) => ms <= this.ms);
    // Before the first picture, that one is shown.
    if (ready < 0 && this.#shown < 0 && this.#pictures.length > 0 && this.#fed > 0 && this.#units[0].ms > this.ms) ready = 0;
    if (ready < 0) return;
    const passed = this.#pictures.splice(0, ready + 1);
    const { image, captured, quarters, ms } = passed[ready];
    this.draw(image, quarters, this.#scenes.get(captured) ?? null, ms);
    this.#shown = ms;
    for (const picture of passed) picture.image.close();
  }
}
