// Why the camera cannot be turned or zoomed by hand now, from the state alone. Pure.

/**
 * @param {object} snapshot
 * @returns {string | null} the key of a line in `words.reasons`; null: it can be turned
 */
export function nudgeObstacle(snapshot) {
  const { mode } = snapshot;
  return mode.name !== "idle" && mode.name !== "nudging" ? "nudge" : obstacleOf(snapshot);
}

/** The same for the zoom, which works while the camera follows, too. */
export function zoomObstacle(snapshot) {
  const { mode } = snapshot;
  return mode.engaged || mode.name === "idle" || mode.name === "nudging" ? obstacleOf(snapshot) : "zoomMode";
}

function obstacleOf({ link, video, alarms }) {
  if (link.state === "dry-run") return "nudgeDryRun";
  if (link.state !== "up" && link.state !== "simulated") return "nudgeLink";
  if (link.in_control === false) return "nudgeControl";
  if (link.flight === "emergency" || link.flight === "landing") return "nudgeFlight";
  if (video.state !== "up" || alarms.includes("no-video")) return "nudgeVideo";
  return null;
}
