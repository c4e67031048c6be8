// The snapshots of the last seconds, so that each picture is drawn with the overlay of its own video frame.
// Pure.

/** Number of video frames whose snapshots are kept. */
const KEPT = 90;

export class SnapshotHistory {
  /** The newest snapshot of each video frame, oldest frame first. */
  #snapshots = [];

  add(snapshot) {
    const captured = snapshot.video.captured_ns;
    if (captured === null) return;
    const last = this.#snapshots.at(-1)?.video.captured_ns ?? -Infinity;
    // Times that run backwards begin anew: another drive, or a source that was restarted.
    if (captured < last) this.#snapshots = [];
    if (captured === last) this.#snapshots.pop();
    this.#snapshots.push(snapshot);
    if (this.#snapshots.length > KEPT) this.#snapshots.shift();
  }

  /** The snapshot of the frame that was captured then, or of the last frame before; null where none is kept. */
  of(captured) {
    return this.#snapshots.findLast((snapshot) => snapshot.video.captured_ns <= captured) ?? null;
  }
}
