// The recordings: the list, and the chosen one with its film, its moments and its files.

import { askForToken, enter } from "/console/access.js";
import { element } from "/console/elements.js";
import { Player } from "/console/player.js";
import { Stage } from "/console/stage.js";
import { Strips } from "/console/strips.js";
import { fillWords, sentence, words } from "/console/words.js";

/** How often the list is asked for while a film is being made, ms. */
const FILM_INTERVAL_MS = 1000;

const $ = (id) => document.getElementById(id);
/** @type {any[]} */
let recordings = [];
let chosen = "";
/** The recording that the player holds. */
let shown = "";
/** The recording that is watched beside it. @type {any} */
let beside;
const stage = watching("picture");
const secondStage = watching("second-picture");
const player = new Player((image, quarters, scene, ms) => draw(stage, "scene", chosenOne(), { image, quarters, scene, ms }));
/** Of the recording that was chosen: its delay is not recorded. */
const strips = new Strips($("strips"), { ...words.strip, delay: "" }, () => player.ms);
const second = new Player((image, quarters, scene, ms) => draw(secondStage, "second-scene", beside, { image, quarters, scene, ms }));

/** A stage on which nothing is chosen. */
function watching(id) {
  const made = new Stage($(id));
  made.isWatchedOnly = true;
  made.layers = new Set(["region", "box", "heading", "trail", "command", "p", "map"]);
  made.label = ({ percept }) => (percept ? `P ${percept.p.toFixed(2)}` : "");
  return made;
}

function draw(on, text, recording, { image, quarters, scene, ms }) {
  const snapshot = scene && { ...scene, video: { captured_ns: scene.captured_ns } };
  on.show(image, quarters, { captured: scene?.captured_ns ?? 0, snapshot });
  if (snapshot && on === stage) strips.add(snapshot, null);
  if (recording) $(text).textContent = sceneText(recording, scene, ms);
  $(text).dataset.ms = String(ms);
}

const place = (name) => `/api/v1/recordings/${encodeURIComponent(name)}`;
const chosenOne = () => recordings.find((recording) => recording.name === chosen);
/** No recording is older than the program; a clock of simulated time begins at 0. */
const began = ({ sortie }) => (sortie && sortie.began_unix_ns > 1e18 ? new Date(sortie.began_unix_ns / 1e6) : null);

/** A length of time: 12.3 s, 4 min 5 s, 1 h 2 min. */
function length(seconds) {
  const whole = Math.round(seconds);
  if (whole < 60) return `${seconds.toFixed(1)} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  return `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
}

function stateOf({ state, sortie }) {
  if (state !== "complete") return words.recordingStates[state];
  const stop = sortie.moments.findLast(({ what }) => what === "stopped");
  return stop && stop.cause !== "ending" ? words.moment(stop) : words.recordingStates.complete;
}

async function load() {
  const response = await fetch("/api/v1/recordings").catch(() => null);
  if (!response) return refuse(words.libraryLost);
  if (!response.ok) return refuse(await response.text());
  recordings = await response.json();
  $("none").hidden = recordings.length > 0;
  $("recordings").replaceChildren(...recordings.map(listed));
  showChosen();
  if (recordings.some((recording) => recording.film === "being-made")) setTimeout(load, FILM_INTERVAL_MS);
}

function listed(recording) {
  const at = began(recording);
  const button = element("button", "", { "aria-current": String(recording.name === chosen) });
  const picture = element("img", "", { alt: "", loading: "lazy" });
  // There may be none: cut off, without video, or the camera is engaged now.
  picture.addEventListener("error", () => picture.remove());
  if (recording.state === "complete") {
    picture.src = `${place(recording.name)}/thumbnail.jpg`;
    button.append(picture);
  }
  button.append(
    element("strong", at ? at.toLocaleString() : recording.name),
    element("small", [recording.sortie && length(recording.sortie.length_s), `${(recording.bytes / 1e6).toFixed(1)} MB`, stateOf(recording)].filter(Boolean).join(" · ")),
    element("small", recording.sortie ? recording.sortie.video : recording.name),
  );
  button.addEventListener("click", () => choose(recording.name));
  const item = document.createElement("li");
  item.append(button);
  return item;
}

function choose(name) {
  chosen = name;
  location.hash = encodeURIComponent(name);
  refuse("");
  for (const [index, button] of [...document.querySelectorAll("#recordings button")].entries()) {
    button.setAttribute("aria-current", String(recordings[index].name === name));
  }
  showChosen();
  $("name").focus();
}

function showChosen() {
  const recording = chosenOne();
  $("detail").hidden = !recording;
  if (!recording) return;
  $("name").textContent = recording.name;
  document.title = `Barrelman: ${recording.name}`;
  $("new-name").value = recording.name;
  showScreen(recording);
  showFiles(recording);
  showSummary(recording);
  showMoments(recording);
  // The slider reaches to the end before the first picture is there.
  showTime();
}

/** What is watched, and the film that can be made of it. */
function showScreen(recording) {
  const isWatchable = recording.state === "complete";
  $("no-picture").textContent = isWatchable ? "" : words.notWatchable[recording.state];
  for (const id of ["bar", "play", "strips"]) $(id).hidden = !isWatchable;
  if (shown !== recording.name) {
    shown = recording.name;
    stage.clear();
    strips.clear();
    player.open(isWatchable ? place(recording.name) : "");
    showBeside();
  }
  $("film-state").textContent = words.filmStates[recording.film];
  const isMakeable = recording.state !== "being-recorded" && ["none", "failed"].includes(recording.film);
  $("make-film").hidden = !isMakeable;
}

/** Which recordings can be watched beside the chosen one. */
function showBeside() {
  const others = recordings.filter(({ name, state }) => name !== chosen && state === "complete");
  $("beside").replaceChildren(new Option(words.besideNone, ""), ...others.map(({ name }) => new Option(name, name)));
  $("beside").disabled = others.length === 0;
  watchBeside("");
}

function watchBeside(name) {
  beside = recordings.find((recording) => recording.name === name);
  $("second-screen").hidden = !beside;
  secondStage.clear();
  $("second-scene").textContent = "";
  second.open(beside ? place(beside.name) : "");
  followBeside();
}

/** The recording beside shows the same time of day where both have one, otherwise the same time since its begin. */
function followBeside() {
  if (!beside) return;
  const [one, other] = [began(chosenOne()), began(beside)];
  const apart = one && other ? one.getTime() - other.getTime() : 0;
  const isTogether = one && other && Math.abs(apart) < 1000 * Math.max(chosenOne().sortie.length_s, beside.sortie.length_s);
  second.follow(Math.max(0, player.ms + (isTogether ? apart : 0)));
}

/** The mode and the time of day of a picture. */
function sceneText(recording, scene, ms) {
  const at = began(recording);
  const time = at ? new Date(at.getTime() + ms).toLocaleTimeString() : `${(ms / 1e3).toFixed(1)} s`;
  return `${scene ? words.modes[scene.mode.name] : ""}  ${time}`.trim();
}

function showTime() {
  const whole = chosenOne()?.sortie?.length_s ?? 0;
  $("position").max = String(Math.round(1000 * whole));
  if (document.activeElement !== $("position") || player.isPlaying) $("position").value = String(Math.round(player.ms));
  $("time").textContent = `${clock(player.ms)} / ${clock(1000 * whole)}`;
  $("play-button").textContent = player.isPlaying ? words.pauseFilm : words.playFilm;
  followBeside();
}

/** Minutes, seconds and tenths. */
function clock(ms) {
  const tenths = Math.floor(ms / 100);
  return `${Math.floor(tenths / 600)}:${String(Math.floor(tenths / 10) % 60).padStart(2, "0")}.${tenths % 10}`;
}

function showFiles(recording) {
  const files = ["recording.mcap", ...(recording.state === "being-recorded" ? [] : ["sortie.json"]), ...recording.exported];
  const stem = recording.name.replace(/\.mcap$/, "");
  $("files").replaceChildren(
    ...files.map((file) => {
      const name = file === "recording.mcap" ? recording.name : `${stem}-${file}`;
      return element("a", words.files[file], { href: `${place(recording.name)}/${file}`, download: name });
    }),
  );
}

/** Asks for the summary of a recording that holds none, or why there is none. */
async function observe(recording) {
  $("no-summary").textContent = words.summaryComputed;
  const response = await fetch(`${place(recording.name)}/sortie.json`).catch(() => null);
  const text = response?.ok ? "" : response ? await response.text() : words.libraryLost;
  if (response?.ok) recording.sortie = await response.json();
  else recording.whyNot = words.noSummary(text.trim());
  if (chosen === recording.name) showChosen();
}

function showSummary(recording) {
  const { state, sortie, whyNot } = recording;
  $("no-summary").textContent = state === "being-recorded" ? words.summaryToCome : (whyNot ?? (state === "cut-off" ? words.summaryOfCut : ""));
  if (!sortie && !whyNot && state === "cut-off") observe(recording);
  $("summary").replaceChildren(
    ...(sortie ? words.sortie(sortie, length) : []).flatMap(([name, value]) => [element("dt", name), element("dd", value)]),
  );
}

const seek = (moment) => player.seek(1000 * moment.at_s);

function showMoments(recording) {
  const at = began(recording);
  const moments = recording.sortie?.moments ?? [];
  $("moments").replaceChildren(
    ...moments.map((moment) => {
      const time = at ? new Date(at.getTime() + moment.at_s * 1e3).toLocaleTimeString() : `${moment.at_s.toFixed(1)} s`;
      const button = element("button", `${time}  ${sentence(words.moment(moment))}`, { "data-what": moment.what });
      button.addEventListener("click", () => seek(moment));
      const item = document.createElement("li");
      item.append(button);
      return item;
    }),
  );
  const whole = recording.sortie?.length_s || 1;
  $("ticks").replaceChildren(
    ...moments.map((moment) => {
      const label = `${moment.at_s.toFixed(1)} s: ${words.moment(moment)}`;
      const tick = element("button", "", { "data-what": moment.what, "aria-label": label, title: label });
      tick.style.left = `${(100 * moment.at_s) / whole}%`;
      tick.addEventListener("click", () => seek(moment));
      return tick;
    }),
  );
}

const refuse = (text) => {
  $("refusal").textContent = text.trim();
};

/** Asks for a change of the chosen recording. Returns whether it was made. */
async function change(method, path, body) {
  const headers = body ? { "Content-Type": "application/json" } : {};
  const response = await fetch(`${place(chosen)}${path}`, { method, headers, body: body && JSON.stringify(body) }).catch(() => null);
  refuse(response ? (response.ok ? "" : await response.text()) : words.libraryLost);
  return response?.ok ?? false;
}

function listen() {
  $("make-film").addEventListener("click", async () => {
    if (await change("POST", "/film")) load();
  });
  $("play-button").addEventListener("click", () => player.play(!player.isPlaying));
  $("back").addEventListener("click", () => player.step(-1));
  $("on").addEventListener("click", () => player.step(1));
  $("position").addEventListener("input", () => player.seek(Number($("position").value)));
  $("beside").addEventListener("change", () => watchBeside($("beside").value));
  $("speed").addEventListener("change", () => {
    player.speed = second.speed = Number($("speed").value);
  });
  player.addEventListener("refused", ({ detail }) => {
    $("no-picture").textContent = (detail ?? words.libraryLost).trim();
  });
  $("change").addEventListener("submit", async (event) => {
    event.preventDefault();
    const to = $("new-name").value.trim();
    if (to !== chosen && (await change("POST", "/name", { to }))) {
      chosen = to;
      location.hash = encodeURIComponent(to);
      load();
    }
  });
  const dialog = /** @type {HTMLDialogElement} */ ($("delete-dialog"));
  $("delete").addEventListener("click", () => dialog.showModal());
  dialog.addEventListener("close", async () => {
    if (dialog.returnValue === "delete" && (await change("DELETE", ""))) {
      chosen = "";
      load();
    }
    dialog.returnValue = "";
  });
}

fillWords();
document.documentElement.dataset.theme = localStorage.getItem("theme") ?? "day";
chosen = decodeURIComponent(location.hash.slice(1).replace(/^token=.*/, ""));
const entry = await enter();
if (entry !== "open") await askForToken(words, entry);
listen();
setInterval(showTime, 100);
await load();
