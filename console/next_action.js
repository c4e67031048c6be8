// What the operator should do next: one line, from the state alone. Pure.

// Stops that the vehicle's own reports caused.
const fromVehicle = new Set(["control-lost", "vehicle-restarted", "vehicle-silent", "battery-low", "exchanged"]);

/** The place of a person is asked for again when its standard deviation is larger, metres: after some seconds. */
const PERSON_STD_DEV_M = 2;

/** The line for a page that does not control. */
const ofWatcher = ({ mayControl, hasAsked }) => (!mayControl ? "watchLink" : hasAsked ? "asked" : "watch");

/**
 * @param {object} state
 * @returns {string} the key of a line in `words.next`, or of an alarm that says itself what to do
 */
export function nextAction({ loss, isConnected, isStopOverdue, seat, snapshot }) {
  if (loss === "ended") return "ended";
  if (isStopOverdue) return "stopUnacknowledged";
  if (loss === "hangs" || loss === "behind") return loss;
  if (loss !== null) return "connect";
  if (!isConnected || !snapshot) return "connecting";
  if (!seat.isControlling) return ofWatcher(seat);
  const { mode, track, video, link, alarms, drive } = snapshot;
  if (drive?.paused && !drive.waits) return "paused";
  if (alarms.includes("drill")) return "drill";
  if (alarms.includes("camera-turns")) return "camera-turns";
  if (alarms.includes("boat-moves")) return "boat-moves";
  if (alarms.includes("boat-may-move")) return "boat-may-move";
  if (video.state !== "up" || alarms.includes("no-video")) return "video";
  if (alarms.includes("camera-may-turn")) return "camera-may-turn";
  if (alarms.includes("stale-video")) return "late";
  if (alarms.includes("link-down")) return "link";
  if (alarms.includes("boat-link-down")) return "boatLink";
  if (alarms.includes("control-lost")) return "vehicle";
  if (alarms.includes("emergency") || mode.cause === "emergency" || mode.cause === "landing") return "emergency";
  if (mode.cause === "pan-opposed" || mode.cause === "tilt-opposed") return "opposed";
  if (mode.name === "nudging") return "nudge";
  if (mode.name === "searching") return "searching";
  if (alarms.includes("net-yaw-limit") && mode.engaged) return "unwind";
  if (track.confirming) return "confirm";
  if (track.state === "unseeded") return snapshot.proposal ? "proposed" : "select";
  if (track.state === "lost") return snapshot.search_refusal ? "reselect" : "search";
  if (mode.name === "stopped") return fromVehicle.has(mode.cause) ? "stoppedByVehicle" : "stopped";
  if (track.doubted) return "doubted";
  if (isPersonOld(snapshot)) return "person";
  if (mode.cause === "dry-run") return "dryRun";
  if (alarms.includes("end-stop")) return "endStop";
  if (mode.name === "idle") return "engage";
  return track.state === "coasting" ? "hidden" : "follow";
}

/** Whether it is not known well any more where a person is. */
function isPersonOld({ vessel }) {
  return Boolean(vessel?.marks.some(({ kind, std_dev_m: deviation }) => kind === "person" && deviation > PERSON_STD_DEV_M));
}
