// Keeps the screen awake while the camera is engaged, where the browser can.

let lock = null;
let isWanted = false;
let isSaid = false;

async function request() {
  if (!isWanted || lock || document.hidden || !navigator.wakeLock) return;
  lock = await navigator.wakeLock.request("screen").catch(() => null);
  lock?.addEventListener("release", () => {
    lock = null;
  });
  // The answer may come after the camera was disengaged.
  if (!isWanted) lock?.release();
}

/**
 * @param {boolean} wanted
 * @param {() => void} onInsecure says, once, that a page without encryption cannot keep the screen awake
 */
export function keepAwake(wanted, onInsecure) {
  if (wanted === isWanted) return;
  isWanted = wanted;
  if (wanted && !isSecureContext && !isSaid) {
    isSaid = true;
    onInsecure();
  }
  if (wanted) request();
  else lock?.release();
}

document.addEventListener("visibilitychange", request);
