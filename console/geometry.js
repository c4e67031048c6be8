// Where the picture lies on the canvas: fit, zoom and pan. Pure.

const MAX_ZOOM = 8;

/** Maps picture pixels to canvas pixels. */
export class View {
  zoom = 1;
  /** The picture's point in the middle of the canvas, as shares of the picture. */
  middle = [0.5, 0.5];

  /** @param {[number, number]} picture @param {[number, number]} canvas */
  fit(picture, canvas) {
    [this.picture, this.canvas] = [picture, canvas];
    this.scale = this.zoom * Math.min(canvas[0] / picture[0], canvas[1] / picture[1]);
    for (const axis of [0, 1]) {
      // No empty border while the picture is larger than the canvas.
      const half = Math.min(0.5, canvas[axis] / this.scale / picture[axis] / 2);
      this.middle[axis] = Math.min(1 - half, Math.max(half, this.middle[axis]));
    }
  }

  toCanvas([u, v]) {
    return [0, 1].map((axis) => ([u, v][axis] - this.middle[axis] * this.picture[axis]) * this.scale + this.canvas[axis] / 2);
  }

  toPicture([x, y]) {
    return [0, 1].map((axis) => ([x, y][axis] - this.canvas[axis] / 2) / this.scale + this.middle[axis] * this.picture[axis]);
  }

  /** Zooms by a factor; the picture's point under a canvas point stays there. */
  zoomBy(factor, at) {
    const fixed = this.toPicture(at);
    this.zoom = Math.min(MAX_ZOOM, Math.max(1, this.zoom * factor));
    this.scale = this.zoom * Math.min(this.canvas[0] / this.picture[0], this.canvas[1] / this.picture[1]);
    this.middle = [0, 1].map((axis) => (fixed[axis] - (at[axis] - this.canvas[axis] / 2) / this.scale) / this.picture[axis]);
    this.fit(this.picture, this.canvas);
  }

  /** Moves the picture by canvas pixels. */
  panBy([x, y]) {
    this.middle = [0, 1].map((axis) => this.middle[axis] - [x, y][axis] / this.scale / this.picture[axis]);
    this.fit(this.picture, this.canvas);
  }

  reset() {
    [this.zoom, this.middle] = [1, [0.5, 0.5]];
    if (this.picture) this.fit(this.picture, this.canvas);
  }
}

/** The box between two corners, within the picture: left, top, width, height. */
export function boxBetween([u1, v1], [u2, v2], [width, height]) {
  const clamp = (value, limit) => Math.min(limit, Math.max(0, value));
  const [left, right] = [clamp(Math.min(u1, u2), width), clamp(Math.max(u1, u2), width)];
  const [top, bottom] = [clamp(Math.min(v1, v2), height), clamp(Math.max(v1, v2), height)];
  return [left, top, right - left, bottom - top];
}
