// The state in words: mode, alarms, next action, figures; and the same as data for scripts.

import { enableControls } from "./controls.js";
import { factsOf } from "./facts.js";
import { nextAction } from "./next_action.js";
import { pictureNotice } from "./picture_notice.js";
import { sentence, words } from "./words.js";

const at = (id) => document.getElementById(id);

/** Sets a text only where it changed, so that screen readers are not told the same again. */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** An advice that is longer is set in a smaller type, letters. */
const LONG_ADVICE = 60;

/** Shows what to do next. */
export function showAdvice(text) {
  setText(at("next-action"), text);
  at("next-action").classList.toggle("long", text.length > LONG_ADVICE);
}

/** The mode, and its cause without what to do about it, which the advice says; of a state that is old, its age. */
export function showMode({ mode, track }, loss, ageS) {
  const confirming = track.confirming ? words.causes.confirming : "";
  const cause = mode.cause ? words.causes[mode.cause] ?? mode.cause : confirming;
  setText(at("mode-name"), loss === "ended" ? words.ended : words.modes[mode.name]);
  setText(at("mode-cause"), loss === null ? cause.split(":")[0] : loss === "ended" ? "" : words.lastKnown(ageS));
  at("mode").title = cause;
  at("mode").dataset.mode = loss === null ? mode.name : "old";
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

/** Shows the alarms in force, short: what to do about the gravest the advice says. */
function showAlarms({ alarms, video }) {
  const list = at("alarms");
  const detail = { "stale-video": video.reason };
  const texts = alarms.map((key) => `⚠ ${sentence((words.alarms[key] ?? key).split(":")[0])}${detail[key] ? `: ${detail[key]}` : ""}`);
  const text = texts.join();
  if (list.dataset.alarms === text) return;
  list.dataset.alarms = text;
  list.replaceChildren(...texts.map((alarm) => {
    const item = document.createElement("li");
    item.textContent = alarm;
    return item;
  }));
}

/** Says across the picture that it does not show what the camera sees now. Returns whether that is so. */
function showNotice(state) {
  const { snapshot, loss, video } = state;
  const behindMs = Math.max(state.behindMs, video.lagMs);
  const notice = pictureNotice({ snapshot, source: video.source, loss, drawnAt: video.drawnAt, behindMs, nowMs: performance.now() });
  setText(at("no-video"), notice === null ? "" : notice.value === undefined ? words.notices[notice.key] : words.notices[notice.key](notice.value));
  at("stage").classList.toggle("stale", notice !== null || loss !== null);
  return notice !== null || loss !== null;
}

/** @param {{snapshot: any, loss: string | null, ageS: number, behindMs: number, isConnected: boolean, seat: any, stopper: any, stage: any, video: any}} state */
export function showStatus(state) {
  const { snapshot, loss, isConnected, seat, stopper, stage, video } = state;
  const root = document.documentElement.dataset;
  root.connected = isConnected ? "yes" : "no";
  root.controlling = seat.isControlling ? "yes" : "no";
  root.frozen = stage.isFrozen ? "yes" : "no";
  root.marking = stage.isMarking ? "yes" : "no";
  root.old = loss === null ? "no" : "yes";
  root.loss = loss ?? "";
  const next = nextAction({ loss, isConnected, isStopOverdue: stopper.isOverdue, seat, snapshot });
  showAdvice(words.next[next] ?? `${sentence(words.alarms[next])}.`);
  root.next = next;
  setText(at("stop-word"), stopper.isPending ? words.stopping : words.stop);
  at("stop").classList.toggle("pending", stopper.isPending);
  const isStale = showNotice(state);
  root.stale = isStale ? "yes" : "no";
  enableControls({ snapshot, isConnected, seat, stage, video });
  // A message that is shown stays where it is.
  if (at("toast").textContent === "") at("stage").dataset.free = stage.isBoxLow ? "top" : "bottom";
  if (!snapshot) return setText(at("mode-name"), words.connecting);
  const { mode, track, percept } = snapshot;
  const delay = isStale ? null : video.delay;
  Object.assign(root, {
    mode: mode.name, cause: mode.cause ?? "", track: track.confirming ? "confirming" : track.state, p: percept?.p.toFixed(3) ?? "",
    stops: snapshot.stops_taken, world: snapshot.world ? `${snapshot.world.scenario} ${snapshot.world.seed}` : "", pan: snapshot.command.pan, tilt: snapshot.command.tilt, link: snapshot.link.state,
    path: video.path, drawn: video.drawn, captured: video.captured,
    delayMs: delay?.median.toFixed(1) ?? "", delayP95Ms: delay?.p95.toFixed(1) ?? "",
  });
  showMode(snapshot, loss, state.ageS);
  showAlarms(snapshot);
  showFacts(at("facts"), factsOf(snapshot));
  setText(at("path"), isStale ? words.paths[video.path]
    : words.picturePath(words.paths[video.path], delay ? Math.round(delay.median) : null, delay ? Math.round(delay.p95) : null));
  if (snapshot.vessel) showVessel(snapshot.vessel);
  if (snapshot.drive) setText(at("pause"), snapshot.drive.paused ? words.resume : words.pause);
}

/** The boat's mode. */
function showVessel(vessel) {
  Object.assign(document.documentElement.dataset, {
    boat: vessel.mode, throttle: vessel.throttle.toFixed(3), rudder: vessel.rudder.toFixed(3), marks: vessel.marks.length,
    distance: vessel.progress?.distance_m.toFixed(2) ?? "", guidance: vessel.guidance ?? "", basis: vessel.basis ?? "",
  });
  const text = words.boatMode(vessel);
  setText(at("boat-mode"), text);
  at("boat-mode").title = text;
  setText(at("guide"), vessel.go_again ? words.guideInPicture : words.guide);
}

/** Shows a message for some seconds. */
export function toast(text, isAlarm = false) {
  const element = at("toast");
  element.textContent = text;
  element.classList.toggle("alarm", isAlarm);
  clearTimeout(toast.timer);
  toast.timer = setTimeout(() => setText(element, ""), 6000);
}
