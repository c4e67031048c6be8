// Keeps the screen awake while the camera is engaged or the boat moves, where the browser can.

/** The system may take a lock back, and grant it again, ms later. */
const AGAIN_MS = 1000;

let lock = null;
let isAsking = false;
let isWanted = false;
let isSaid = false;
let sayDark = () => {};

async function request() {
  if (!isWanted || lock || isAsking || document.hidden) return;
  isAsking = true;
  lock = (await navigator.wakeLock?.request("screen").catch(() => null)) ?? null;
  isAsking = false;
  lock?.addEventListener("release", () => {
    lock = null;
    setTimeout(request, AGAIN_MS);
  });
  // The answer may come after the camera was disengaged.
  if (!isWanted) lock?.release();
  else if (!lock && !isSaid) {
    isSaid = true;
    sayDark();
  }
}

/**
 * @param {boolean} wanted
 * @param {() => void} onDark says, once, that the screen cannot be kept awake
 */
export function keepAwake(wanted, onDark) {
  if (wanted === isWanted) return;
  [isWanted, sayDark] = [wanted, onDark];
  if (wanted) request();
  else lock?.release();
}

document.addEventListener("visibilitychange", request);
