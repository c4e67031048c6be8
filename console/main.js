// The page: joins its parts.

import { askForToken, enter } from "./access.js";
import { ControlSeat } from "./control_seat.js";
import { openDialog } from "./dialogs.js";
import { EventList } from "./events.js";
import { GamepadHelm } from "./gamepad.js";
import { HeldControl } from "./held_controls.js";
import { Link } from "./link.js";
import { nudgeObstacle } from "./nudge_obstacle.js";
import { LAYERS } from "./overlay.js";
import { Sounds } from "./sounds.js";
import { Stage } from "./stage.js";
import { showStatus, toast } from "./status.js";
import { Stopper } from "./stop.js";
import { Strips } from "./strips.js";
import { Video } from "./video.js";
import { keepAwake } from "./wake_lock.js";
import { fillWords, sentence, words } from "./words.js";

const at = (id) => document.getElementById(id);
fillWords();

const link = new Link();
const stopper = new Stopper(link);
const stage = new Stage(at("picture"));
const video = new Video(link, (image, quarters, of) => stage.show(image, quarters, of));
const seat = new ControlSeat(link);
const events = new EventList();
const sounds = new Sounds();
const strips = new Strips(at("strips"), words.strip);
let snapshot = null;

const show = () => showStatus({ snapshot, isConnected: link.isUp, isControlling: seat.isControlling, stopper, stage, video });

/** Makes a request; a refusal is shown with its reason. */
async function request(wanted) {
  const { answer, reason, unsent, unanswered } = await link.request(wanted);
  if (unsent) toast(words.reasons.notConnected, true);
  else if (unanswered) toast(words.reasons.noAnswer, true);
  else if (answer !== "accepted") toast(`${words.answers[answer]}: ${reason ?? ""}`);
  else if (reason) toast(reason);
}

stage.label = ({ percept, track }) =>
  [percept ? `P ${percept.p.toFixed(2)}` : "", track.state === "tracking" ? "" : words.tracks[track.state]].filter(Boolean).join("  ");
stage.addEventListener("change", () => {
  at("frozen").hidden = !stage.isFrozen;
  at("frozen-bar").style.width = `${Math.round(100 * stage.frozenShare)}px`;
  at("freeze").textContent = stage.isFrozen ? words.unfreeze : words.freeze;
  at("freeze").setAttribute("aria-pressed", String(stage.isFrozen));
});
stage.addEventListener("say", ({ detail }) => toast(words.reasons[detail]));
stage.addEventListener("change", () => {
  at("mark").setAttribute("aria-pressed", String(stage.isMarking));
  at("mark").textContent = stage.isMarking ? words.marking : words.mark;
  at("stage").classList.toggle("marking", stage.isMarking);
});
/** A point of a picture as a request has it. */
const onFrame = ({ at: [u, v], captured_ns }) => ({ at: { u, v }, captured_ns });
stage.addEventListener("mark", ({ detail }) => {
  if (!seat.isControlling) return toast(words.reasons.watcher);
  request({ kind: "mark", mark: at("mark-kind").value, ...onFrame(detail) });
});
stage.addEventListener("move-mark", ({ detail }) => {
  if (!seat.isControlling) return toast(words.reasons.watcher);
  request({ kind: "move-mark", id: detail.id, ...onFrame(detail) });
});
stage.addEventListener("select", ({ detail }) => {
  if (!seat.isControlling) return toast(words.reasons.watcher);
  stage.trail.clear();
  const [u, v, w, h] = detail.box;
  request({ kind: "select", bounds: { u, v, w, h }, captured_ns: detail.captured_ns });
});

/** The loop of a live run takes a turn every 0.2 s at least: one that has taken none for so long hangs, whatever else is still sent. */
const HANGS_MS = 1500;
let beatAt = 0;
let isHung = false;

/** Says whether the program can be heard, and whether it still decides. */
function showLoss() {
  const loss = !link.isUp ? (link.isDismissed ? words.dismissed : words.connectionLost) : isHung ? words.hangs : "";
  at("lost").hidden = loss === "";
  at("lost").textContent = loss;
  at("stage").classList.toggle("stale", loss !== "");
  if (loss !== "") sounds.play("alarm");
}

let lastMode = null;
link.addEventListener("snapshot", ({ detail }) => {
  if (detail.beat !== snapshot?.beat) beatAt = performance.now();
  snapshot = detail;
  strips.add(snapshot, video.delay?.median ?? null);
  const { vessel } = snapshot;
  const isBoatMoving = seat.isControlling && ["by-hand", "guided", "holding"].includes(vessel?.mode);
  link.isWatchingBoat = isBoatMoving;
  keepAwake(snapshot.mode.engaged || isBoatMoving);
  const { alarms } = snapshot;
  if (lastMode && alarms.some((alarm) => !lastMode.alarms.includes(alarm))) sounds.play("alarm");
  else if (lastMode && lastMode.name !== snapshot.mode.name) sounds.play(snapshot.mode.name === "stopped" ? "stop" : "good");
  lastMode = { name: snapshot.mode.name, alarms };
});
link.addEventListener("hello", ({ detail }) => {
  at("where").textContent = `${detail.command}  ${detail.source}`;
  at("law").replaceChildren(...detail.laws.map((law) => new Option(sentence(words.laws[law]), law)));
});
link.addEventListener("events", ({ detail }) => events.reset(detail.events));
link.addEventListener("event", ({ detail }) => events.add(detail));
link.addEventListener("up", () => {
  beatAt = performance.now();
  showLoss();
});
// A program that was started anew does not know the cookie: the page begins anew, and asks for a token.
link.addEventListener("refused", () => location.reload());
let wasOverdue = false;
setInterval(() => {
  stage.tick();
  // A demo that is paused rests.
  const wasHung = isHung;
  isHung = link.isUp && snapshot !== null && !snapshot.drive && performance.now() - beatAt > HANGS_MS;
  if (isHung !== wasHung) showLoss();
  show();
  if (stopper.isOverdue && !wasOverdue) {
    toast(words.reasons.unacknowledged, true);
    sounds.play("alarm");
  }
  wasOverdue = stopper.isOverdue;
}, 100);
stopper.addEventListener("change", show);

const turn = new HeldControl({
  keys: { w: "up", a: "left", s: "down", d: "right" },
  buttons: "nudge",
  everyMs: 80,
  mayStart: () => seat.isControlling && Boolean(snapshot) && !nudgeObstacle(snapshot),
  send: ([pan, tilt]) => request({ kind: "nudge", pan, tilt }),
});
const maySteer = () => seat.isControlling && Boolean(snapshot?.vessel);
const steer = ([right, ahead]) => request({ kind: "steer", throttle: ahead, rudder: right });
const helm = new HeldControl({
  keys: { ArrowUp: "up", ArrowLeft: "left", ArrowDown: "down", ArrowRight: "right" },
  buttons: "helm",
  everyMs: 150,
  mayStart: maySteer,
  send: steer,
});
const gamepad = new GamepadHelm({ mayStart: maySteer, send: steer });
setInterval(() => gamepad.tick(), 150);

const act = {
  engage: () => request({ kind: "engage" }),
  disengage: () => request({ kind: "disengage" }),
  reject: () => request({ kind: "reject" }),
  deselect: () => request({ kind: "deselect" }),
  search: () => request({ kind: "search" }),
  "net-yaw-zero": () => request({ kind: "net-yaw", degrees: 0 }),
  pause: () => request({ kind: snapshot?.drive?.paused ? "resume" : "pause" }),
  helmsman: () => request({ kind: "release-vessel" }),
  mark: () => stage.setMarking(!stage.isMarking),
  "unmark-all": () => request({ kind: "unmark-all" }),
  guide: () => request({ kind: "guide" }),
  "stop-boat": () => request({ kind: "stop-vessel" }),
  "next-mark": () => request({ kind: "next-mark" }),
  "go-home": () => request({ kind: "go-home" }),
  freeze: () => (stage.isFrozen ? stage.unfreeze() : stage.freeze()),
  stop: () => stopper.press(),
  theme: () => {
    const isNight = document.documentElement.dataset.theme !== "night";
    document.documentElement.dataset.theme = isNight ? "night" : "day";
    at("theme").textContent = isNight ? words.themeDay : words.theme;
    localStorage.setItem("theme", isNight ? "night" : "day");
  },
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
at("law").addEventListener("change", async (event) => {
  await request({ kind: "law", law: event.target.value });
  // A refused choice goes back to the law in force.
  delete event.target.dataset.law;
});

const KEYS = { t: "mark", g: "guide", b: "stop-boat", c: "next-mark", y: "go-home", e: "engage", r: "disengage", f: "freeze", x: "reject", l: "search", p: "pause", h: "helmsman", n: "theme", m: "sound", "?": "keys", "+": "zoom-in", "-": "zoom-out", 0: "zoom-reset" };
/** Whether keys write text there. A checkbox takes none: Enter switches it. */
const takesText = (element) => element instanceof HTMLInputElement && element.type !== "checkbox";
addEventListener("keydown", (event) => {
  const isText = takesText(event.target);
  if (event.key === " " && !isText) {
    if (!event.repeat) act.stop();
    event.preventDefault();
    event.stopPropagation();
    return;
  }
  if (isText || event.ctrlKey || event.altKey || event.metaKey || event.target instanceof HTMLSelectElement) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (turn.onKey(key, true) || helm.onKey(key, true)) event.preventDefault();
  else if (!event.repeat && KEYS[key] && !at(KEYS[key]).disabled) act[KEYS[key]]();
}, { capture: false });
addEventListener("keyup", (event) => {
  if (event.key === " " && !takesText(event.target)) event.preventDefault();
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  turn.onKey(key, false) || helm.onKey(key, false);
});

/** The switches of the overlay, kept for the next time. */
function fillLayers() {
  const off = new Set((localStorage.getItem("layersOff") ?? "").split(",").filter(Boolean));
  for (const layer of LAYERS) {
    if (!off.has(layer)) stage.layers.add(layer);
    const [row, box] = [document.createElement("label"), document.createElement("input")];
    [box.type, box.id, box.checked] = ["checkbox", `layer-${layer}`, !off.has(layer)];
    box.addEventListener("keydown", (event) => event.key === "Enter" && box.click());
    box.addEventListener("change", () => {
      if (box.checked) stage.layers.add(layer);
      else stage.layers.delete(layer);
      localStorage.setItem("layersOff", LAYERS.filter((name) => !stage.layers.has(name)).join());
      stage.redraw();
    });
    row.append(box, ` ${words.layers[layer]}`);
    at("overlay-list").append(row);
  }
}

at("mark-kind").replaceChildren(...Object.entries(words.markKinds).map(([kind, text]) => new Option(text, kind)));
for (const [key, meaning] of words.keyList) {
  const [name, text] = [document.createElement("dt"), document.createElement("dd")];
  [name.textContent, text.textContent] = [key, meaning];
  at("keys-list").append(name, text);
}
fillLayers();
if (localStorage.getItem("theme") === "night") act.theme();
at("log").open = innerWidth >= 1100;
at("next-action").textContent = words.connecting;
if (!(await enter())) await askForToken(words);
link.start();
