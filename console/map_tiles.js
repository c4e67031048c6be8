// Tiles of the operator's own map, below the water from above. The program serves them; none come from elsewhere.

const RAD = Math.PI / 180;
/** Radius of the sphere of Web Mercator, m. */
const RADIUS_M = 6378137;
/** Side of a tile, pixels. */
const TILE_PX = 256;
/** Tiles that are kept; those that were not shown for longest go. */
const MAX_KEPT = 96;
const MAP = "/api/v1/map";
/** Pauses before a tile that did not come is asked for again: each is twice the last, up to the longest. */
const [FIRST_PAUSE_MS, LONGEST_PAUSE_MS] = [1000, 60000];
/** How long the program may take to answer, ms: a connection that is lost may never tell. */
const ANSWER_TIMEOUT_MS = 10000;
/** The answers where there is no tile. */
const NO_TILE = [204, 404];

/** Whom the map names, and which zooms have tiles; `null`: no map. */
let about = null;
/** Tiles by `zoom/x/y`, the one shown last at the end. @type {Map<string, Tile>} */
const kept = new Map();

/** A tile, which is asked for until it is there, or until the program says that there is none. */
class Tile {
  /** @type {ImageBitmap | null} */
  picture = null;
  /** When it is asked for next, ms. */
  #askAt = 0;
  #pause = FIRST_PAUSE_MS;

  ask(key, nowMs) {
    if (nowMs < this.#askAt) return;
    this.#askAt = Infinity;
    this.#load(`${MAP}/${key}`).catch(() => {
      this.#askAt = performance.now() + this.#pause;
      this.#pause = Math.min(2 * this.#pause, LONGEST_PAUSE_MS);
    });
  }

  async #load(address) {
    const response = await fetch(address, { signal: AbortSignal.timeout(ANSWER_TIMEOUT_MS) });
    if (NO_TILE.includes(response.status)) return;
    if (!response.ok) throw new Error(`${response.status}`);
    this.picture = await createImageBitmap(await response.blob());
  }
}

/** The map that the program has, or `null`. @param {{min_zoom: number, max_zoom: number, attribution: string | null} | null} map */
export function setMap(map) {
  about = map;
}

/** The picture of a tile, or `null` where there is none, or none yet. */
function pictureOf(key) {
  const tile = kept.get(key) ?? new Tile();
  kept.delete(key);
  kept.set(key, tile);
  for (const old of kept.keys()) {
    if (kept.size <= MAX_KEPT) break;
    kept.delete(old);
  }
  tile.ask(key, performance.now());
  return tile.picture;
}

/** Tile coordinates of a place at a zoom. */
function tileOf({ latitude_deg: latitude, longitude_deg: longitude }, zoom) {
  const side = 2 ** zoom;
  return [((longitude + 180) / 360) * side, ((1 - Math.asinh(Math.tan(latitude * RAD)) / Math.PI) / 2) * side];
}

/** A place on Earth as a point on the water, m to the right of the vehicle and ahead of it. */
export function onWater({ below_camera: below, ahead_deg: ahead }, place) {
  const perDegree = RADIUS_M * RAD;
  const north = (place.latitude_deg - below.latitude_deg) * perDegree;
  const east = (place.longitude_deg - below.longitude_deg) * perDegree * Math.cos(below.latitude_deg * RAD);
  const [sin, cos] = [Math.sin(ahead * RAD), Math.cos(ahead * RAD)];
  return [east * cos - north * sin, east * sin + north * cos];
}

/** Whether there is a map for this place. */
export function hasMap(place) {
  return about !== null && Boolean(place);
}

/**
 * Draws the tiles that a square shows. `origin`: where the canvas shows the place below the camera; `scale`: canvas pixels for
 * a metre; `box`: the square's left, top and side. Ahead is up.
 */
export function drawTiles(pen, place, origin, scale, [left, top, side], unit) {
  const { below_camera: below, ahead_deg: ahead } = place;
  const metres = 2 * Math.PI * RADIUS_M * Math.cos(below.latitude_deg * RAD);
  // The zoom whose tiles are drawn smaller rather than larger than they are.
  const wanted = Math.ceil(Math.log2((metres * scale) / (TILE_PX * unit)));
  const zoom = Math.max(about.min_zoom, Math.min(about.max_zoom, wanted));
  const size = (metres / 2 ** zoom) * scale;
  const [x0, y0] = tileOf(below, zoom);
  const reach = Math.hypot(side, side) / 2;
  const middle = [left + side / 2 - origin[0], top + side / 2 - origin[1]];
  const [sin, cos] = [Math.sin(ahead * RAD), Math.cos(ahead * RAD)];
  // The middle of the square from the origin, in a frame with north up.
  const [east, south] = [middle[0] * cos - middle[1] * sin, middle[0] * sin + middle[1] * cos];
  const [fromX, toX] = [east - reach, east + reach].map((at, end) => Math.floor(x0 + at / size) + end);
  const [fromY, toY] = [south - reach, south + reach].map((at, end) => Math.floor(y0 + at / size) + end);
  if ((toX - fromX) * (toY - fromY) > MAX_KEPT) return;
  pen.save();
  pen.translate(...origin);
  pen.rotate(-ahead * RAD);
  for (let x = fromX; x < toX; x += 1) {
    for (let y = fromY; y < toY; y += 1) {
      const picture = pictureOf(`${zoom}/${x}/${y}`);
      if (picture) pen.drawImage(picture, (x - x0) * size, (y - y0) * size, size, size);
    }
  }
  pen.restore();
  if (!about.attribution) return;
  pen.font = `${9 * unit}px system-ui, sans-serif`;
  pen.textAlign = "end";
  pen.lineWidth = 3 * unit;
  pen.strokeStyle = "#000000";
  pen.fillStyle = "#ffffff";
  const at = [left + side - 4 * unit, top + side - 4 * unit];
  pen.strokeText(about.attribution, ...at, side - 8 * unit);
  pen.fillText(about.attribution, ...at, side - 8 * unit);
  pen.textAlign = "start";
}
