// Keeps the screen awake while the camera is engaged, where the browser can.

let lock = null;
let isWanted = false;

async function request() {
  if (!isWanted || lock || document.hidden || !navigator.wakeLock) return;
  lock = await navigator.wakeLock.request("screen").catch(() => null);
  lock?.addEventListener("release", () => {
    lock = null;
  });
  // The answer may come after the camera was disengaged.
  if (!isWanted) lock?.release();
}

/** @param {boolean} wanted */
export function keepAwake(wanted) {
  if (wanted === isWanted) return;
  isWanted = wanted;
  if (wanted) request();
  else lock?.release();
}

document.addEventListener("visibilitychange", request);
