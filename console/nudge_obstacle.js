// Why the camera cannot be turned by hand now, from the state alone. Pure.

/**
 * @param {object} snapshot
 * @returns {string | null} the key of a line in `words.reasons`; null: it can be turned
 */
export function nudgeObstacle({ mode, link, video, alarms }) {
  if (mode.name !== "idle" && mode.name !== "nudging") return "nudge";
  if (link.state === "dry-run") return "nudgeDryRun";
  if (link.state !== "up" && link.state !== "simulated") return "nudgeLink";
  if (link.in_control === false) return "nudgeControl";
  if (link.flight === "emergency" || link.flight === "landing") return "nudgeFlight";
  if (video.state !== "up" || alarms.includes("no-video")) return "nudgeVideo";
  return null;
}
