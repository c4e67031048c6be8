// The page: joins its parts.

import { askForToken, enter } from "./access.js";
import { Appearance } from "./appearance.js";
import { ControlSeat } from "./control_seat.js";
import { openDialog } from "./dialogs.js";
import { Drills } from "./drills.js";
import { EventList } from "./events.js";
import { GamepadStick } from "./gamepad.js";
import { Heartbeat } from "./heartbeat.js";
import { HeldControl } from "./held_controls.js";
import { helpPlace } from "./help_place.js";
import { Hints } from "./hints.js";
import { listenToKeys } from "./keys.js";
import { Layers } from "./layers.js";
import { Link } from "./link.js";
import { Devices } from "./devices.js";
import { NewDrive } from "./new_drive.js";
import { setMap } from "./map_tiles.js";
import { nudgeObstacle, zoomObstacle } from "./nudge_obstacle.js";
import { Sounds } from "./sounds.js";
import { Stage } from "./stage.js";
import { showStatus, toast } from "./status.js";
import { Stopper } from "./stop.js";
import { Strips } from "./strips.js";
import { TwoVideos } from "./two_videos.js";
import { Video } from "./video.js";
import { keepAwake } from "./wake_lock.js";
import { fillWords, fixed, sentence, words } from "./words.js";

const at = (id) => document.getElementById(id);
fillWords();

const link = new Link();
const stopper = new Stopper(link);
const stage = new Stage(at("picture"));
const video = new Video(link, (image, quarters, of) => stage.show(image, quarters, of));
const seat = new ControlSeat(link);
const devices = new Devices(link);
const events = new EventList();
const sounds = new Sounds();
const strips = new Strips(at("strips"), words.strip);
const layers = new Layers(stage, at("overlay-list"));
const appearance = new Appearance((isExpert) => layers.show(isExpert));
const heartbeat = new Heartbeat();
const hints = new Hints(stage);
let snapshot = null;
let loss = null;

function show() {
  const now = performance.now();
  const behindMs = link.behindMs(now);
  const ageS = Math.max(heartbeat.ageS(now), Math.floor(behindMs / 1000));
  showStatus({ snapshot, loss, ageS, behindMs, isConnected: link.isUp, seat, stopper, stage, video });
}

/** Makes a request; a refusal is shown with its reason. */
async function request(wanted, done = "") {
  const { answer, reason, unsent, unanswered } = await link.request(wanted);
  if (unsent) toast(words.reasons.notConnected, true);
  else if (unanswered) toast(words.reasons.noAnswer, true);
  else if (answer !== "accepted") toast(`${words.answers[answer]}: ${reason ?? ""}`);
  else if (reason || done) toast(reason || done);
}

const twoVideos = new TwoVideos(request, stage, video);
const newDrive = new NewDrive(request);
const drills = new Drills(request, toast);
newDrive.addEventListener("begun", () => {
  stage.unfreeze();
  stage.trail.clear();
});
stage.label = ({ percept, track }) =>
  [percept ? `P ${fixed(percept.p, 2)}` : "", track.state === "tracking" ? "" : words.tracks[track.state]].filter(Boolean).join("  ");
stage.addEventListener("change", () => {
  at("frozen").hidden = !stage.isFrozen;
  at("frozen-bar").style.width = `${Math.round(100 * stage.frozenShare)}px`;
  at("freeze").textContent = stage.isFrozen ? words.unfreeze : words.freeze;
  at("freeze").setAttribute("aria-pressed", String(stage.isFrozen));
  at("mark").setAttribute("aria-pressed", String(stage.isMarking));
  at("mark").textContent = stage.isMarking ? words.marking : words.mark;
  at("stage").classList.toggle("marking", stage.isMarking);
});
stage.addEventListener("say", ({ detail }) => toast(words.reasons[detail]));
/** A point of a picture as a request has it. */
const onFrame = ({ at: [u, v], captured_ns }) => ({ at: { u, v }, captured_ns });
/** Does what the page in control may do. */
const onStage = (name, act) => stage.addEventListener(name, ({ detail }) => (seat.isControlling ? act(detail) : toast(seat.whyNot)));
onStage("mark", (detail) => request({ kind: "mark", mark: detail.mark ?? at("mark-kind").value, ...onFrame(detail) }));
onStage("move-mark", (detail) => request({ kind: "move-mark", id: detail.id, ...onFrame(detail) }));
onStage("tap-mark", ({ mark, captured_ns }) => {
  stage.chosenMark = mark.id;
  // A person who is still there: the mark is moved to where it is.
  if (mark.kind === "person") request({ kind: "move-mark", id: mark.id, ...onFrame({ at: mark.at, captured_ns }) }, words.stillThere);
});
onStage("propose", (detail) => request({ kind: "propose", ...onFrame(detail) }));
onStage("select", (detail) => {
  stage.trail.clear();
  const [u, v, w, h] = detail.box;
  request({ kind: "select", bounds: { u, v, w, h }, captured_ns: detail.captured_ns });
});

/** Says whether the program can be heard, and whether it still decides. */
function showLoss() {
  const before = loss;
  loss = heartbeat.loss(link, performance.now());
  if (loss === before) return;
  at("lost").hidden = loss === null;
  at("lost").dataset.loss = loss ?? "";
  at("lost").textContent = loss === null ? "" : loss === "ended" ? words.endedText(leftMoving()) : words.losses[loss];
  if (loss !== null && loss !== "ended") sounds.play("alarm");
}

/** What may move after the end: by the program's last words, and by its last alarms. */
function leftMoving() {
  const has = (alarm) => Boolean(snapshot?.alarms.includes(alarm));
  return { camera: link.left.camera || has("camera-turns"), boat: link.left.boat || has("boat-moves") };
}

let lastMode = null;
link.addEventListener("snapshot", ({ detail }) => {
  heartbeat.onSnapshot(detail, performance.now());
  snapshot = detail;
  stage.setProposal(snapshot.proposal?.box ?? null);
  newDrive.onSnapshot(snapshot);
  drills.onSnapshot(snapshot);
  twoVideos.onSnapshot(snapshot);
  strips.add(snapshot, video.delay?.median ?? null);
  const { vessel } = snapshot;
  const isBoatMoving = seat.isControlling && ["by-hand", "guided", "holding"].includes(vessel?.mode);
  keepAwake(snapshot.mode.engaged || isBoatMoving, () => toast(words.reasons.screenMayGoDark(isSecureContext)));
  const { alarms } = snapshot;
  if (lastMode && alarms.some((alarm) => !lastMode.alarms.includes(alarm))) sounds.play("alarm");
  else if (lastMode && lastMode.name !== snapshot.mode.name) sounds.play(snapshot.mode.name === "stopped" ? "stop" : "good");
  lastMode = { name: snapshot.mode.name, alarms };
});
link.addEventListener("hello", ({ detail }) => {
  at("where").textContent = `${detail.command}  ${detail.source}`;
  newDrive.onHello(detail);
  twoVideos.onHello(detail);
  setMap(detail.map);
  at("law").replaceChildren(...detail.laws.map((law) => new Option(sentence(words.laws[law]), law)));
  // The new list has not chosen the law in force.
  delete at("law").dataset.law;
});
link.addEventListener("events", ({ detail }) => events.reset(detail.events));
link.addEventListener("event", ({ detail }) => events.add(detail));
link.addEventListener("up", ({ detail }) => {
  if (detail) heartbeat.onUp(performance.now());
  showLoss();
});
// A program that was started anew does not know the cookie: the page begins anew, and asks for a token.
link.addEventListener("refused", () => location.reload());
let wasOverdue = false;
setInterval(() => {
  stage.tick();
  showLoss();
  if (snapshot) hints.tick(snapshot);
  show();
  if (stopper.isOverdue && !wasOverdue) {
    toast(words.reasons.unacknowledged, true);
    sounds.play("alarm");
  }
  wasOverdue = stopper.isOverdue;
}, 100);
stopper.addEventListener("change", show);

/** What is held of the camera: each control renews all of it. */
const byHand = { pan: 0, tilt: 0, zoom: 0 };
const nudge = (part) => request({ kind: "nudge", ...Object.assign(byHand, part) });
const turn = new HeldControl({
  keys: { w: "up", a: "left", s: "down", d: "right" },
  buttons: "nudge",
  everyMs: 80,
  mayStart: () => seat.isControlling && Boolean(snapshot) && !nudgeObstacle(snapshot),
  send: ([pan, tilt]) => nudge({ pan, tilt }),
});
const mayZoom = () => seat.isControlling && Boolean(snapshot?.zoom) && !zoomObstacle(snapshot);
const lens = new HeldControl({
  keys: { PageUp: "up", PageDown: "down" },
  buttons: "lens",
  directions: ["up", "down"],
  everyMs: 80,
  mayStart: mayZoom,
  send: ([, zoom]) => nudge({ zoom }),
});
at("picture").addEventListener("wheel", (event) => {
  if (!event.shiftKey) return;
  lens.holdBriefly((event.deltaY || event.deltaX) < 0 ? "up" : "down");
  event.preventDefault();
}, { passive: false });
const maySteer = () => seat.isControlling && Boolean(snapshot?.vessel);
/** Neutral lets the helm go. One that waited when Stop came was not taken, and the helm would count as held. */
async function steer([right, ahead]) {
  const wanted = { kind: "steer", throttle: ahead, rudder: right };
  if (right !== 0 || ahead !== 0) return request(wanted);
  const { answer } = await link.request(wanted);
  if (answer === "superseded") steer([0, 0]);
}
const helm = new HeldControl({
  keys: { ArrowUp: "up", ArrowLeft: "left", ArrowDown: "down", ArrowRight: "right" },
  buttons: "helm",
  everyMs: 150,
  mayStart: maySteer,
  send: steer,
});
const helmStick = new GamepadStick({ axes: [0, 1], mayStart: maySteer, send: steer });
const lensStick = new GamepadStick({ axes: [2, 3], mayStart: mayZoom, send: ([, zoom]) => nudge({ zoom }) });
setInterval(() => [helmStick, lensStick].forEach((stick) => stick.tick()), 150);

/** What steers the boat, or turns the camera, and was held through a stop holds it no more. */
const letGoOfBoat = () => [helm, helmStick].forEach((control) => control.release());
const letGoOfCamera = () => [turn, lens, lensStick].forEach((control) => control.release());
let stopped = { stops: 0, camera: false, boat: false };
/** The stop of this page has let go already: what is pressed after it is not to be let go when the program tells of it. */
let isOwnStopUntil = 0;
const letGoByOwnStop = (...controls) => {
  controls.forEach((letGo) => letGo());
  isOwnStopUntil = performance.now() + 1000;
};
link.addEventListener("snapshot", ({ detail }) => {
  const now = { stops: detail.stops_taken, camera: detail.mode.name === "stopped", boat: detail.vessel?.mode === "stopped" };
  if (performance.now() > isOwnStopUntil) {
    const isStop = now.stops !== stopped.stops;
    if (isStop || (now.camera && !stopped.camera)) letGoOfCamera();
    if (isStop || (now.boat && !stopped.boat)) letGoOfBoat();
  }
  stopped = now;
});

/** Removes the mark that was tapped last, otherwise the newest. */
function unmark() {
  const marks = snapshot?.vessel?.marks ?? [];
  const mark = marks.find(({ id }) => id === stage.chosenMark) ?? marks.at(-1);
  if (mark) request({ kind: "unmark", id: mark.id });
}

const act = {
  engage: () => request({ kind: "engage" }),
  disengage: () => request({ kind: "disengage" }),
  reject: () => request({ kind: "reject" }),
  candidates: () => request({ kind: "candidates", shown: !snapshot?.candidates_on_demand }),
  deselect: () => request({ kind: "deselect" }),
  search: () => request({ kind: "search" }),
  "keep-size": () => request({ kind: "keep-size", keep: !snapshot?.zoom?.keeps_size }),
  "net-yaw-zero": () => request({ kind: "net-yaw", degrees: 0 }),
  pause: () => request({ kind: snapshot?.drive?.paused ? "resume" : "pause" }),
  "new-drive": () => newDrive.open(),
  drills: () => drills.open(),
  "hints-again": () => hints.again(),
  devices: () => devices.open(),
  helmsman: () => request({ kind: "release-vessel" }),
  mark: () => stage.setMarking(!stage.isMarking),
  unmark,
  "unmark-all": () => request({ kind: "unmark-all" }),
  guide: () => request({ kind: "guide" }),
  "stop-boat": () => {
    request({ kind: "stop-vessel" });
    letGoByOwnStop(letGoOfBoat);
  },
  "next-mark": () => request({ kind: "next-mark" }),
  "go-home": () => request({ kind: "go-home" }),
  note: () => request({ kind: "note" }, words.noted),
  freeze: () => (stage.isFrozen ? stage.unfreeze() : stage.freeze()),
  stop: () => {
    stopper.press();
    letGoByOwnStop(letGoOfCamera, letGoOfBoat);
  },
  video: () => twoVideos.change(),
  "track-video": () => twoVideos.track(),
  level: () => appearance.changeLevel(),
  "full-screen": () => appearance.changeFullScreen(),
  theme: () => appearance.changeTheme(),
  sound: () => {
    sounds.toggle();
    at("sound").textContent = sounds.isOn ? words.soundOn : words.sound;
    at("sound").setAttribute("aria-pressed", String(sounds.isOn));
  },
  keys: () => openDialog(at("keys-dialog")),
  "zoom-in": () => stage.zoomBy(1.5),
  "zoom-out": () => stage.zoomBy(1 / 1.5),
  "zoom-reset": () => stage.resetZoom(),
};
for (const [id, action] of Object.entries(act)) if (id !== "stop") at(id).addEventListener("click", action);
// Stop acts when it is pressed, not when it is let go.
at("stop").addEventListener("pointerdown", act.stop);
at("stop").addEventListener("click", (event) => event.detail === 0 && act.stop());
// The manual opens where it speaks of the present state.
at("help").addEventListener("click", () => {
  at("help").href = `/help#${helpPlace(snapshot)}`;
});
at("law").addEventListener("change", async (event) => {
  await request({ kind: "law", law: event.target.value });
  // A refused choice goes back to the law in force.
  delete event.target.dataset.law;
});
const take = (number) => request({ kind: "take-candidate", number });
listenToKeys({ act, take, held: [turn, lens, helm], onEscape: () => stage.isMarking && stage.setMarking(false) });

at("mark-kind").replaceChildren(...Object.entries(words.markKinds).map(([kind, text]) => new Option(text, kind)));
for (const [key, meaning] of words.keyList) {
  const [name, text] = [document.createElement("dt"), document.createElement("dd")];
  [name.textContent, text.textContent] = [key, meaning];
  at("keys-list").append(name, text);
}
at("log").open = true;
show();
const entry = await enter();
if (entry !== "open") await askForToken(words, entry);
link.start();
