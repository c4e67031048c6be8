// The state in words: mode, alarms, next action, figures, control; and the same as data for scripts.

import { nextAction } from "./next_action.js";
import { nudgeObstacle } from "./nudge_obstacle.js";
import { sentence, words } from "./words.js";

/** A simulated world below this share of real time is named as slow. */
const SLOW = 0.9;

/** From this net yaw on, the page offers to set it to zero: after the tether was untwisted by hand. */
const SHOWN_NET_YAW_DEG = 180;

const at = (id) => document.getElementById(id);

/** Sets a text only where it changed, so that screen readers are not told the same again. */
function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function modeText({ mode, track }) {
  const cause = mode.cause ? `: ${words.causes[mode.cause] ?? mode.cause}` : "";
  const confirming = track.confirming && !mode.cause ? `: ${words.causes.confirming}` : "";
  return `${words.modes[mode.name]}${cause}${confirming}`;
}

/** A rate with its sign and its direction: pan is positive to the right, tilt upwards. */
function rateText({ pan, tilt }) {
  const turn = (axis, rate, plus, minus) => (rate ? [`${axis} ${rate > 0 ? "+" : "\u2212"}${Math.abs(rate).toFixed(2)} rad/s (${rate > 0 ? plus : minus})`] : []);
  const { left, right, up, down, rest, pan: panWord, tilt: tiltWord } = words.turns;
  return [...turn(panWord, pan, right, left), ...turn(tiltWord, tilt, up, down)].join(", ") || rest;
}

function factsOf(snapshot) {
  const { track, percept, video, link, recording, work, drive } = snapshot;
  const number = (value, digits = 2) => (value === null || value === undefined ? "–" : value.toFixed(digits));
  const lost = track.lost_s !== null ? ` ${words.ago(track.lost_s.toFixed(0))}` : "";
  const distance = snapshot.boat ? `, ${words.distanceText(snapshot.boat)}` : "";
  const facts = [
    [words.facts.track, words.tracks[track.confirming ? "confirming" : track.state] + lost + distance],
    [words.facts.p, `${number(percept?.p)}${work.schema_p === null ? "" : `  (${words.facts.schemaP}: ${number(work.schema_p)})`}`],
    [words.facts.confidence, number(track.confidence)],
    [words.facts.camera, rateText(snapshot.command)],
    [words.facts.video, words.videoText(words.videos[video.state], video.fps, video.dropped) + (video.reason ? `: ${video.reason}` : "")],
    [words.facts.link, words.links[link.state] + (link.battery_v === null ? "" : `, ${link.battery_v.toFixed(1)} V`)],
    [words.facts.recording, words.recordings[recording.state] + (recording.path ? `: ${recording.path.split("/").at(-1)}` : "")],
    [words.facts.work, words.workText(work.camera)],
    [words.facts.netYaw, words.netYawText(Math.round(snapshot.net_yaw_deg))],
  ];
  if (link.position) facts.push([words.facts.position, words.positionText(link.position, link.altitude_m)]);
  facts.push(...placesOf(snapshot));
  if (work.schema) facts.push([words.facts.schema, words.workText(work.schema)]);
  if (snapshot.vessel) facts.push([words.facts.boat, words.vesselText(snapshot.vessel, drive)]);
  else if (drive) facts.push([words.facts.boat, words.boatText(drive)]);
  if (drive && !drive.paused && drive.pace < SLOW) facts.push([words.facts.world, words.slowText(drive.pace)]);
  return facts;
}

/** Latitude and longitude of the boat and of the target; of a kite with a position alone, why they are not known. */
function placesOf({ boat, vessel, earth }) {
  if (earth === "no-heading") return [[words.facts.boatPlace, words.noHeading]];
  const boatPlace = vessel?.progress?.on_earth ?? boat?.on_earth;
  const target = vessel?.marks.find(({ destination }) => destination)?.on_earth;
  return [[words.facts.boatPlace, boatPlace], [words.facts.targetPlace, target]]
    .filter(([, place]) => place).map(([name, place]) => [name, words.placeText(place)]);
}

/** Shows a list of names and values; rows are reused. */
function showFacts(list, facts) {
  while (list.children.length > 2 * facts.length) list.lastElementChild.remove();
  facts.forEach(([name, value], index) => {
    if (!list.children[2 * index]) list.append(document.createElement("dt"), document.createElement("dd"));
    setText(list.children[2 * index], name);
    setText(list.children[2 * index + 1], value);
  });
}

/** Shows the alarms in force. */
function showAlarms({ alarms, video }) {
  const list = at("alarms");
  const detail = { "stale-video": video.reason };
  const texts = alarms.map((key) => `⚠ ${sentence(words.alarms[key] ?? key)}${detail[key] ? `: ${detail[key]}` : ""}`);
  const text = texts.join();
  if (list.dataset.alarms === text) return;
  list.dataset.alarms = text;
  list.replaceChildren(...texts.map((alarm) => {
    const item = document.createElement("li");
    item.textContent = alarm;
    return item;
  }));
}

/** Shows everything. @param {{snapshot: any, isConnected: boolean, isControlling: boolean, stopper: any, stage: any, video: any}} state */
export function showStatus(state) {
  const { snapshot, isConnected, isControlling, stopper, stage, video } = state;
  const root = document.documentElement.dataset;
  root.connected = isConnected ? "yes" : "no";
  root.controlling = isControlling ? "yes" : "no";
  root.frozen = stage.isFrozen ? "yes" : "no";
  const next = nextAction({ isConnected, isStopOverdue: stopper.isOverdue, isControlling, snapshot });
  setText(at("next-action"), words.next[next] ?? `${sentence(words.alarms[next])}.`);
  root.next = next;
  setText(at("stop-word"), stopper.isPending ? words.stopping : words.stop);
  at("stop").classList.toggle("pending", stopper.isPending);
  if (!snapshot) return;
  const { mode, track, percept } = snapshot;
  Object.assign(root, {
    mode: mode.name, cause: mode.cause ?? "", track: track.confirming ? "confirming" : track.state, p: percept?.p.toFixed(3) ?? "",
    stops: snapshot.stops_taken, pan: snapshot.command.pan, tilt: snapshot.command.tilt, link: snapshot.link.state,
    path: video.path, drawn: video.drawn, captured: video.captured,
    delayMs: video.delay?.median.toFixed(1) ?? "", delayP95Ms: video.delay?.p95.toFixed(1) ?? "",
  });
  setText(at("mode"), modeText(snapshot));
  at("mode").dataset.mode = mode.name;
  showAlarms(snapshot);
  showFacts(at("facts"), factsOf(snapshot));
  const delay = video.delay;
  setText(at("path"), words.picturePath(words.paths[video.path], delay ? Math.round(delay.median) : null, delay ? Math.round(delay.p95) : null));
  const can = isConnected && isControlling;
  /** Enables a control, or says why not; a page that does not control says that. */
  const set = (id, isPossible, why) => {
    const element = at(id);
    element.disabled = !(can && isPossible);
    element.title = !element.disabled ? "" : can ? why : words.reasons.watcher;
  };
  set("engage", !mode.engaged, words.reasons.engaged);
  set("disengage", mode.name !== "idle", words.reasons.disengaged);
  set("reject", track.state === "tracking" || track.state === "coasting", words.reasons.nothingFollowed);
  set("deselect", track.state !== "unseeded", words.reasons.nothingFollowed);
  // Offered once the boat is lost; the title says why a search is not possible yet.
  at("search").hidden = track.state !== "lost" && mode.name !== "searching";
  set("search", !snapshot.search_refusal && mode.name !== "searching", snapshot.search_refusal ?? "");
  at("net-yaw-zero").hidden = Math.abs(snapshot.net_yaw_deg) < SHOWN_NET_YAW_DEG;
  set("net-yaw-zero", true);
  set("law", !mode.engaged, words.reasons.law);
  const obstacle = nudgeObstacle(snapshot);
  for (const direction of ["up", "down", "left", "right"]) {
    set(`nudge-${direction}`, !obstacle, words.reasons[obstacle]);
    set(`helm-${direction}`, Boolean(snapshot.vessel), words.reasons.noBoat);
  }
  for (const id of ["pause", "helmsman"]) set(id, true);
  // A list that the operator has open is left alone.
  // A law that is not in the list leaves it empty.
  const law = snapshot.law ?? "";
  if (at("law").dataset.law !== law) at("law").value = at("law").dataset.law = law;
  const { vessel } = snapshot;
  at("drive").hidden = at("boat").hidden = at("marks").hidden = !vessel;
  at("world").hidden = !snapshot.drive;
  at("helmsman").hidden = !vessel;
  if (vessel) showVessel(vessel, set);
  if (snapshot.drive) setText(at("pause"), snapshot.drive.paused ? words.resume : words.pause);
}

/** The boat's mode, and what can be done with it. */
function showVessel(vessel, set) {
  const goals = vessel.marks.filter(({ kind }) => kind === "place" || kind === "person");
  const isGuided = vessel.mode === "guided" || vessel.mode === "holding";
  Object.assign(document.documentElement.dataset, {
    boat: vessel.mode, throttle: vessel.throttle.toFixed(3), rudder: vessel.rudder.toFixed(3), marks: vessel.marks.length,
    distance: vessel.progress?.distance_m.toFixed(2) ?? "", guidance: vessel.guidance ?? "", basis: vessel.basis ?? "",
  });
  setText(at("boat-mode"), words.boatMode(vessel));
  set("mark", true);
  set("mark-kind", true);
  set("unmark-all", vessel.marks.length > 0, words.reasons.nothingMarked);
  setText(at("guide"), vessel.go_again ? words.guideInPicture : words.guide);
  set("guide", !isGuided && goals.length > 0, words.reasons.nothingMarked);
  set("stop-boat", vessel.mode !== "stopped", words.reasons.boatStopped);
  set("next-mark", goals.length > 1, words.reasons.nothingMarked);
  set("go-home", vessel.marks.some(({ kind }) => kind === "home"), words.reasons.noHome);
}

/** Shows a message for some seconds. */
export function toast(text, isAlarm = false) {
  const element = at("toast");
  element.textContent = text;
  element.classList.toggle("alarm", isAlarm);
  clearTimeout(toast.timer);
  toast.timer = setTimeout(() => setText(element, ""), 6000);
}
