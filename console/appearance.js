// How the page looks: the level (Operate or Expert), day or night, full screen. The browser remembers level
// and theme.

import { words } from "./words.js";

const at = (id) => document.getElementById(id);
const root = document.documentElement;

export class Appearance {
  /** @param {(isExpert: boolean) => void} onLevel */
  constructor(onLevel) {
    this.onLevel = onLevel;
    this.#showLevel(localStorage.getItem("level") === "expert");
    this.#showTheme(localStorage.getItem("theme") === "night");
    document.addEventListener("fullscreenchange", () => {
      at("full-screen").textContent = document.fullscreenElement ? words.fullScreenEnd : words.fullScreen;
    });
    // A telephone's browser may have none.
    at("full-screen").disabled = !document.fullscreenEnabled;
  }

  #showLevel(isExpert) {
    root.dataset.level = isExpert ? "expert" : "operate";
    at("level").textContent = isExpert ? words.operate : words.expert;
    this.onLevel(isExpert);
  }

  #showTheme(isNight) {
    root.dataset.theme = isNight ? "night" : "day";
    at("theme").textContent = isNight ? words.themeDay : words.theme;
  }

  changeLevel() {
    const isExpert = root.dataset.level !== "expert";
    localStorage.setItem("level", isExpert ? "expert" : "operate");
    this.#showLevel(isExpert);
  }

  changeTheme() {
    const isNight = root.dataset.theme !== "night";
    localStorage.setItem("theme", isNight ? "night" : "day");
    this.#showTheme(isNight);
  }

  changeFullScreen() {
    if (document.fullscreenElement) document.exitFullscreen();
    else root.requestFullscreen?.().catch(() => {});
  }
}
