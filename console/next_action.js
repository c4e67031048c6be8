// What the operator should do next: one line, from the state alone. Pure.

// Stops that the vehicle's own reports caused.
const fromVehicle = new Set(["control-lost", "vehicle-restarted", "vehicle-silent", "battery-low"]);

/**
 * @param {object} state
 * @returns {string} the key of a line in `words.next`, or of an alarm that says itself what to do
 */
export function nextAction({ isConnected, isStopOverdue, isControlling, snapshot }) {
  if (isStopOverdue) return "stopUnacknowledged";
  if (!isConnected || !snapshot) return "connect";
  if (!isControlling) return "watch";
  const { mode, track, video, link, alarms, drive } = snapshot;
  if (drive?.paused) return "paused";
  if (alarms.includes("camera-turns")) return "camera-turns";
  if (alarms.includes("boat-moves")) return "boat-moves";
  if (video.state !== "up" || alarms.includes("no-video")) return "video";
  if (alarms.includes("camera-may-turn")) return "camera-may-turn";
  if (alarms.includes("stale-video")) return "late";
  if (alarms.includes("link-down")) return "link";
  if (alarms.includes("control-lost")) return "vehicle";
  if (alarms.includes("emergency") || mode.cause === "emergency" || mode.cause === "landing") return "emergency";
  if (mode.cause === "pan-opposed" || mode.cause === "tilt-opposed") return "opposed";
  if (mode.name === "nudging") return "nudge";
  if (mode.name === "searching") return "searching";
  if (alarms.includes("net-yaw-limit") && mode.engaged) return "unwind";
  if (track.confirming) return "confirm";
  if (track.state === "unseeded") return "select";
  if (track.state === "lost") return snapshot.search_refusal ? "reselect" : "search";
  if (mode.name === "stopped") return fromVehicle.has(mode.cause) ? "stoppedByVehicle" : "stopped";
  if (mode.cause === "dry-run") return "dryRun";
  if (alarms.includes("end-stop")) return "endStop";
  if (mode.name === "idle") return "engage";
  return track.state === "coasting" ? "hidden" : "follow";
}
