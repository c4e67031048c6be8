// Tiles of the operator's own map, below the water from above. The program serves them; none come from elsewhere.

const RAD = Math.PI / 180;
/** Radius of the sphere of Web Mercator, m. */
const RADIUS_M = 6378137;
/** Side of a tile, pixels. */
const TILE_PX = 256;
/** Tiles that are kept; those that were not shown for longest go. */
const MAX_KEPT = 96;
const MAP = "/api/v1/map";

/** Whom the map names, and which zooms have tiles; `null`: no map. */
let about = null;
/** Images by `zoom/x/y`, the one shown last at the end; `null` where there is no tile. */
const kept = new Map();

/** The map that the program has, or `null`. @param {{min_zoom: number, max_zoom: number, attribution: string | null} | null} map */
export function setMap(map) {
  about = map;
}

function image(key) {
  let found = kept.get(key);
  kept.delete(key);
  if (found === undefined) {
    found = new Image();
    found.onerror = () => kept.set(key, null);
    found.src = `${MAP}/${key}`;
  }
  kept.set(key, found);
  for (const old of kept.keys()) {
    if (kept.size <= MAX_KEPT) break;
    kept.delete(old);
  }
  return found?.complete && found.naturalWidth > 0 ? found : null;
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
      const tile = image(`${zoom}/${x}/${y}`);
      if (tile) pen.drawImage(tile, (x - x0) * size, (y - y0) * size, size, size);
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
