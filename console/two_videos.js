// Two videos: which one the page shows, and the change of the one in which the boat is followed.

import { words } from "./words.js";

const at = (id) => document.getElementById(id);
const OTHER = { first: "second", second: "first" };
const COUNT = { first: 1, second: 2 };

export class TwoVideos {
  #request;
  #stage;
  #video;
  #tracked = "first";

  /** @param {(wanted: object) => Promise<void>} request @param {import("./stage.js").Stage} stage @param {import("./video.js").Video} video */
  constructor(request, stage, video) {
    [this.#request, this.#stage, this.#video] = [request, stage, video];
  }

  onHello({ second_source: second }) {
    at("videos").hidden = second === null;
  }

  /** Shows the other video. */
  change() {
    this.#show(OTHER[this.#video.shown]);
  }

  /** Asks for the boat to be followed in the video that is shown. */
  track() {
    this.#request({ kind: "track-video", video: this.#video.shown });
  }

  onSnapshot({ video }) {
    if (video.number !== this.#tracked) {
      this.#tracked = video.number;
      this.#stage.trail.clear();
      this.#show(video.number);
    }
    const isTracked = this.#video.shown === video.number;
    this.#stage.isWatchedOnly = !isTracked;
    at("video").textContent = words.videoShown(COUNT[this.#video.shown], isTracked);
  }

  #show(number) {
    this.#stage.isWatchedOnly = number !== this.#tracked;
    this.#stage.unfreeze();
    // A box on the picture of the other video would be taken for one on this video.
    if (number !== this.#video.shown) this.#stage.clear();
    this.#video.show(number);
  }
}
