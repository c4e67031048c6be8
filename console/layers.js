// The layers of the overlay: those of each level, and the switches of the expert's, which the browser
// remembers.

import { LAYERS } from "./overlay.js";
import { words } from "./words.js";

/** What an operator needs to see over the picture. */
const OPERATE = new Set(["region", "box", "heading", "command", "marks", "map"]);

export class Layers {
  #expert = new Set();
  #stage;

  /** @param {import("./stage.js").Stage} stage @param {HTMLElement} list the place of the switches */
  constructor(stage, list) {
    this.#stage = stage;
    const off = new Set((localStorage.getItem("layersOff") ?? "").split(",").filter(Boolean));
    for (const layer of LAYERS) {
      if (!off.has(layer)) this.#expert.add(layer);
      const [row, box] = [document.createElement("label"), document.createElement("input")];
      [box.type, box.id, box.checked] = ["checkbox", `layer-${layer}`, !off.has(layer)];
      box.addEventListener("keydown", (event) => event.key === "Enter" && box.click());
      box.addEventListener("change", () => this.#switch(layer, box.checked));
      row.append(box, ` ${words.layers[layer]}`);
      list.append(row);
    }
    this.show(false);
  }

  #switch(layer, isOn) {
    if (isOn) this.#expert.add(layer);
    else this.#expert.delete(layer);
    localStorage.setItem("layersOff", LAYERS.filter((name) => !this.#expert.has(name)).join());
    this.#stage.redraw();
  }

  /** Draws the layers of a level. */
  show(isExpert) {
    [this.#stage.layers, this.#stage.isCalm] = [isExpert ? this.#expert : OPERATE, !isExpert];
    this.#stage.redraw();
  }
}
