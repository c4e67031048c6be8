// What stands across the picture where it does not show what the camera sees now. Pure.

/** A picture that is older is not that of now, ms. */
const OLD_MS = 1000;

/** What is said before the first picture, by the state of the video. */
const WITHOUT_PICTURE = { connecting: "videoConnecting", up: "waiting", ended: "ended" };

/**
 * @param {{snapshot: any, source: any, loss: string | null, drawnAt: number | null, behindMs: number, nowMs: number}} state `source`: the state of the video that is shown; `drawnAt`: when a picture was drawn last; `behindMs`: by how much the page is late
 * @returns {{key: string, value?: any} | null} a line in `words.notices`, and what it needs
 */
export function pictureNotice({ snapshot, source, loss, drawnAt, behindMs, nowMs }) {
  if (!snapshot || !source) return { key: "connecting" };
  const { state, reason } = source;
  if (drawnAt === null) return state === "lost" ? { key: "lost", value: reason } : { key: WITHOUT_PICTURE[state] };
  if (loss === "ended" || loss === "dismissed") return { key: "old" };
  if (snapshot.drive?.paused && loss === null) return null;
  if (state === "ended") return { key: "ended" };
  if (behindMs > OLD_MS) return { key: "behind", value: Math.floor(behindMs / 1000) };
  return nowMs - drawnAt > OLD_MS ? { key: "none", value: Math.floor((nowMs - drawnAt) / 1000) } : null;
}
