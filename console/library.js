// The recordings: the list, and the chosen one with its film, its moments and its files.

import { askForToken, enter } from "/console/access.js";
import { fillWords, sentence, words } from "/console/words.js";

/** How often the list is asked for while a film is being made, ms. */
const FILM_INTERVAL_MS = 1000;
/** A step of the film: a picture of 30 a second. */
const STEP_S = 1 / 30;

const $ = (id) => document.getElementById(id);
const film = /** @type {HTMLVideoElement} */ ($("film"));
/** @type {any[]} */
let recordings = [];
let chosen = "";
/** The film that the player holds. */
let shown = "";

const place = (name) => `/api/v1/recordings/${encodeURIComponent(name)}`;
const chosenOne = () => recordings.find((recording) => recording.name === chosen);
/** No recording is older than the program; a clock of simulated time begins at 0. */
const began = ({ sortie }) => (sortie && sortie.began_unix_ns > 1e18 ? new Date(sortie.began_unix_ns / 1e6) : null);

function element(tag, text, attributes = {}) {
  const made = document.createElement(tag);
  made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

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
  showFilm(recording);
  showFiles(recording);
  showSummary(recording);
  showMoments(recording);
}

function showFilm(recording) {
  const isReady = recording.film === "ready";
  for (const id of ["film", "bar", "play"]) $(id).hidden = !isReady;
  $("no-film").hidden = isReady;
  $("film-state").textContent = words.filmStates[recording.film];
  $("make-film").hidden = recording.film === "being-made" || recording.state === "being-recorded";
  const wanted = isReady ? `${place(recording.name)}/annotated.mp4` : "";
  if (wanted === shown) return;
  shown = wanted;
  if (wanted) film.src = wanted;
  else film.removeAttribute("src");
}

function showFiles(recording) {
  const files = ["recording.mcap", ...(recording.state === "being-recorded" ? [] : ["sortie.json"]), ...(recording.film === "ready" ? ["annotated.mp4", "video.mp4", "trial.csv"] : [])];
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

/** The moment on the film's own time: the film begins with the first picture that the pilot saw. */
const seek = (moment) => {
  film.currentTime = Math.max(0, Math.min(moment.at_s, film.duration || moment.at_s));
};

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
  $("back").addEventListener("click", () => step(-STEP_S));
  $("on").addEventListener("click", () => step(STEP_S));
  $("speed").addEventListener("change", () => {
    film.playbackRate = Number($("speed").value);
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

function step(seconds) {
  film.pause();
  film.currentTime += seconds;
}

fillWords();
document.documentElement.dataset.theme = localStorage.getItem("theme") ?? "day";
chosen = decodeURIComponent(location.hash.slice(1).replace(/^token=.*/, ""));
if (!(await enter())) await askForToken(words);
listen();
await load();
