// A new drive: another simulated world, chosen by its scenario and its seed.

import { openDialog } from "./dialogs.js";
import { words } from "./words.js";

const at = (id) => document.getElementById(id);

/** Says "begun" when another world has taken the place of the one before. */
export class NewDrive extends EventTarget {
  #command = "";
  #scenarios = [];
  #world = null;

  /** @param {(wanted: object) => Promise<void>} request makes a request and shows its refusal */
  constructor(request) {
    super();
    at("scenario").addEventListener("change", () => this.#describe());
    at("drive-form").addEventListener("submit", ({ submitter }) => {
      if (submitter?.value === "begin") request({ kind: "new-drive", scenario: at("scenario").value, seed: at("seed").valueAsNumber });
    });
  }

  /** The scenarios that there are. @param {{command: string, scenarios: {name: string, summary: string}[]}} hello */
  onHello({ command, scenarios }) {
    [this.#command, this.#scenarios] = [command, scenarios];
    at("scenario").replaceChildren(...scenarios.map(({ name }) => new Option(name)));
  }

  /** @param {{world: {scenario: string, seed: number} | null}} snapshot */
  onSnapshot({ world }) {
    const isSame = world?.scenario === this.#world?.scenario && world?.seed === this.#world?.seed;
    if (isSame) return;
    const isFirst = this.#world === null;
    this.#world = world;
    if (world) at("where").textContent = words.worldText(this.#command, world);
    if (!isFirst) this.dispatchEvent(new Event("begun"));
  }

  /** Opens the dialog: the same scenario, with the next seed. */
  open() {
    if (!this.#world) return;
    at("scenario").value = this.#world.scenario;
    at("seed").value = this.#world.seed + 1;
    this.#describe();
    openDialog(at("drive-dialog"));
    at("scenario").focus();
  }

  #describe() {
    const chosen = this.#scenarios.find(({ name }) => name === at("scenario").value);
    at("scenario-summary").textContent = chosen?.summary ?? "";
  }
}
