// Which controls are enabled, and why the others are not. A control that does not apply stays in its place.

import { nudgeObstacle, zoomObstacle } from "./nudge_obstacle.js";
import { words } from "./words.js";

/** From this net yaw on, it can be set to zero: after the tether was untwisted by hand. */
const UNTWISTED_FROM_DEG = 180;

const DIRECTIONS = ["up", "down", "left", "right"];
const at = (id) => document.getElementById(id);

/** @param {{snapshot: any, isConnected: boolean, seat: any, stage: any, video: any}} state */
export function enableControls({ snapshot, isConnected, seat, stage, video }) {
  const isAble = isConnected && snapshot !== null;
  const can = isAble && seat.isControlling;
  const show = (id, isPossible, why) => {
    at(id).disabled = !isPossible;
    at(id).title = isPossible ? "" : why;
  };
  /** Enables a control of the page in control, or says why not. */
  const set = (id, isPossible, why = "") =>
    show(id, can && isPossible, !isAble ? words.reasons.notConnected : seat.isControlling ? why : seat.whyNot);
  const mayAsk = isAble && seat.mayControl && !seat.isControlling;
  const whyNot = seat.isControlling ? words.reasons.controls : seat.mayControl ? words.next.asked : words.reasons.watchLink;
  show("take-control", mayAsk, whyNot);
  show("ask-control", mayAsk && !seat.hasAsked, whyNot);
  const isRecording = snapshot?.recording.state === "recording";
  show("note", isAble && seat.mayControl && isRecording, !isAble ? words.reasons.notConnected : seat.mayControl ? words.reasons.notRecorded : words.reasons.watchLink);
  show("freeze", stage.hasPicture, words.reasons.noPicture);
  show("video", isAble, words.reasons.notConnected);
  const isShown = snapshot?.video.number === video.shown;
  const isAtRest = ["idle", "stopped"].includes(snapshot?.mode.name);
  set("track-video", !isShown && isAtRest, isShown ? words.reasons.isTracked : words.reasons.videoAtRest);
  setCamera(snapshot, set);
  setBoat(snapshot?.vessel ?? null, set);
  for (const id of ["pause", "helmsman", "new-drive", "drills"]) set(id, true);
  if (!snapshot) return;
  // A law that is not in the list leaves it empty. A list that the operator has open is left alone.
  const law = snapshot.law ?? "";
  if (at("law").dataset.law !== law) at("law").value = at("law").dataset.law = law;
  // What a vehicle has is known after the first step, and stays.
  if (snapshot.step === 0) return;
  at("drive").hidden = at("boat").hidden = at("marks").hidden = !snapshot.vessel;
  for (const id of ["lens-up", "lens-down", "keep-size"]) at(id).hidden = !snapshot.zoom;
  at("world").hidden = !snapshot.world;
  at("pause").hidden = at("drills").hidden = !snapshot.drive;
  at("helmsman").hidden = !snapshot.vessel;
}

function setCamera(snapshot, set) {
  const { mode, track, net_yaw_deg: netYaw, search_refusal: refusal } = snapshot ?? { mode: {}, track: {} };
  // Engaging a camera that rests for a doubt says that it is the boat.
  set("engage", !mode.engaged || track.doubted, words.reasons.engaged);
  set("disengage", mode.name !== "idle", words.reasons.disengaged);
  set("reject", track.state === "tracking" || track.state === "coasting", words.reasons.nothingFollowed);
  at("candidates").setAttribute("aria-pressed", String(Boolean(snapshot?.candidates_on_demand)));
  set("deselect", track.state !== "unseeded", words.reasons.nothingFollowed);
  const isSearchable = track.state === "lost" && mode.name !== "searching";
  set("search", isSearchable && !refusal, (isSearchable && refusal) || words.reasons.notLost);
  set("net-yaw-zero", Math.abs(netYaw) >= UNTWISTED_FROM_DEG, words.reasons.notTwisted);
  set("law", !mode.engaged, words.reasons.law);
  const obstacle = snapshot && nudgeObstacle(snapshot);
  for (const direction of DIRECTIONS) set(`nudge-${direction}`, !obstacle, words.reasons[obstacle]);
  const noZoom = snapshot && zoomObstacle(snapshot);
  for (const direction of ["up", "down"]) set(`lens-${direction}`, !noZoom, words.reasons[noZoom]);
  set("keep-size", true);
  at("keep-size").setAttribute("aria-pressed", String(Boolean(snapshot?.zoom?.keeps_size)));
}

function setBoat(vessel, set) {
  const { noBoat, nothingMarked, noHome, boatStopped } = words.reasons;
  const marks = vessel?.marks ?? [];
  const goals = marks.filter(({ kind }) => kind === "place" || kind === "person");
  const isGuided = vessel?.mode === "guided" || vessel?.mode === "holding";
  for (const direction of DIRECTIONS) set(`helm-${direction}`, vessel !== null, noBoat);
  for (const id of ["mark", "mark-kind"]) set(id, vessel !== null, noBoat);
  for (const id of ["unmark", "unmark-all"]) set(id, marks.length > 0, nothingMarked);
  set("guide", !isGuided && goals.length > 0, isGuided ? words.reasons.guided : nothingMarked);
  set("stop-boat", vessel !== null && vessel.mode !== "stopped", boatStopped);
  set("next-mark", goals.length > 1, nothingMarked);
  set("go-home", marks.some(({ kind }) => kind === "home"), noHome);
}
