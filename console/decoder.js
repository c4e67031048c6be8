// Decodes H.264 and H.265 by WebCodecs. Reports when the browser cannot do it, so that JPEG takes over.

import { codecOf } from "./video_message.js";

const MAX_ERRORS = 2;
const ERROR_WINDOW_MS = 5000;
const SILENCE_MS = 2000;
/** Units in the decoder beyond which a stream counts as reordered: the delay would grow. */
const MAX_REORDERED = 6;

export const isWebCodecsPossible = () => "VideoDecoder" in window && window.isSecureContext;

export class UnitDecoder {
  #decoder = null;
  #codec = null;
  #epoch = null;
  #next = null;
  #needsKey = true;
  #errors = [];
  #sentAt = new Map();
  #firstSent = 0;
  #hasOutput = false;

  /** @param {(frame: VideoFrame, unit: any) => void} onFrame @param {(why: string) => void} onGiveUp */
  constructor(onFrame, onGiveUp) {
    [this.onFrame, this.onGiveUp] = [onFrame, onGiveUp];
  }

  /** Decodes one unit; see `readVideoMessage`. */
  async decode(unit) {
    if (unit.epoch !== this.#epoch || unit.index !== this.#next) this.#needsKey = true;
    [this.#epoch, this.#next] = [unit.epoch, unit.index + 1];
    if (this.#needsKey && !unit.key) return;
    if (unit.key && !this.#configure(unit)) return;
    this.#needsKey = false;
    const now = performance.now();
    if (!this.#hasOutput) {
      this.#firstSent ||= now;
      if (now - this.#firstSent > SILENCE_MS) return this.#giveUp("no pictures");
    }
    const timestamp = Math.round(unit.captured / 1000);
    this.#sentAt.set(timestamp, unit);
    // Units that still wait for the decoder, as after a start within a long group of pictures, are no
    // reordering.
    const isHeld = this.#sentAt.size - (this.#decoder?.decodeQueueSize ?? 0) > MAX_REORDERED * 4;
    if (this.#hasOutput && isHeld) return this.#giveUp("reordered pictures");
    try {
      this.#decoder.decode(new EncodedVideoChunk({ type: unit.key ? "key" : "delta", timestamp, data: unit.payload }));
    } catch (error) {
      this.#onError(error);
    }
  }

  #configure(unit) {
    const codec = codecOf(unit.kind, unit.payload);
    if (codec === null) return this.#codec !== null;
    if (codec === this.#codec && this.#decoder?.state === "configured") return true;
    this.close();
    this.#codec = codec;
    this.#decoder = new VideoDecoder({
      output: (frame) => {
        this.#hasOutput = true;
        const sent = this.#sentAt.get(frame.timestamp);
        for (const timestamp of this.#sentAt.keys()) if (timestamp <= frame.timestamp) this.#sentAt.delete(timestamp);
        if (sent?.shown) this.onFrame(frame, sent);
        else frame.close();
      },
      error: (error) => this.#onError(error),
    });
    try {
      this.#decoder.configure({ codec, optimizeForLatency: true });
    } catch (error) {
      this.#onError(error);
      return false;
    }
    return true;
  }

  #onError(error) {
    // The browser, or its machine, has no decoder of the codec.
    if (error?.name === "NotSupportedError") return this.#giveUp(String(error));
    const now = performance.now();
    this.#errors = this.#errors.filter((at) => now - at < ERROR_WINDOW_MS);
    this.#errors.push(now);
    this.skip();
    if (this.#errors.length >= MAX_ERRORS) this.#giveUp(String(error));
  }

  #giveUp(why) {
    this.close();
    this.onGiveUp(why);
  }

  /** The unit that waits longest for its picture; null where none does. */
  get waiting() {
    return this.#sentAt.values().next().value ?? null;
  }

  /** Gives up what waits, and goes on with the next key frame. */
  skip() {
    this.close();
    this.#needsKey = true;
  }

  close() {
    if (this.#decoder && this.#decoder.state !== "closed") this.#decoder.close();
    [this.#decoder, this.#codec] = [null, null];
    this.#sentAt.clear();
  }
}
