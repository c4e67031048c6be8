// Where the manual speaks of the present state. Pure.

/** The row of each mode in the manual. */
const MODES = { idle: "disengaged", servoing: "following", holding: "holding", nudging: "turned-by-hand", searching: "searching", calibrating: "calibrating", stopped: "stopped" };

/** The anchor of an alarm in force, otherwise of the mode; empty: the beginning. Other alarms come before a lost boat. */
export function helpPlace(snapshot) {
  if (!snapshot) return "";
  const { alarms, mode } = snapshot;
  const alarm = alarms.find((key) => key !== "track-lost") ?? alarms[0];
  return alarm ? `alarm-${alarm}` : MODES[mode.name];
}
