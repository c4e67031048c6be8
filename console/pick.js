// The page on which the operator draws the box around the boat in one picture of a video file.

import { askForToken, enter } from "./access.js";
import { Stage } from "./stage.js";
import { fillWords, words } from "./words.js";

const at = (id) => document.getElementById(id);
fillWords();

const stage = new Stage(at("picture"));
let box = null;

function toast(text) {
  at("toast").textContent = text;
  clearTimeout(toast.timer);
  toast.timer = setTimeout(() => (at("toast").textContent = ""), 6000);
}

stage.addEventListener("say", ({ detail }) => toast(words.reasons[detail]));
stage.addEventListener("propose", () => toast(words.reasons.tap));
stage.addEventListener("select", ({ detail }) => {
  box = detail.box.map(Math.round);
  stage.kept = box;
  stage.redraw();
  at("box").textContent = words.pickBox(box);
  at("take").disabled = false;
});
at("zoom-in").addEventListener("click", () => stage.zoomBy(1.5));
at("zoom-out").addEventListener("click", () => stage.zoomBy(1 / 1.5));
at("zoom-reset").addEventListener("click", () => stage.resetZoom());
at("take").addEventListener("click", async () => {
  const body = JSON.stringify({ box });
  const answer = await fetch("/api/v1/selection", { method: "POST", headers: { "Content-Type": "application/json" }, body }).catch(() => null);
  if (!answer?.ok) return toast(answer ? await answer.text() : words.reasons.notConnected);
  at("take").disabled = true;
  document.documentElement.dataset.picked = box.join();
  const { console: link } = await answer.json();
  at("hint").textContent = link ? words.pickDoneConsole : words.pickDone;
  if (link) await openConsole(link);
});

/** Opens the console at this page's address, once the program serves it there. @param {string} link */
async function openConsole(link) {
  while (!(await fetch("/healthz").catch(() => null))?.ok) await new Promise((resolve) => setTimeout(resolve, 200));
  history.replaceState(null, "", new URL(link).pathname + new URL(link).hash);
  location.reload();
}

at("hint").textContent = words.pickHint;
const entry = await enter();
if (entry !== "open") await askForToken(words, entry);
const answer = await fetch("/api/v1/frame");
stage.show(await createImageBitmap(await answer.blob()), 0, { captured: 0, snapshot: null });
