// Chooses the table of words and fills it into the page.

const wanted = new URLSearchParams(location.search).get("lang");
const english = (await import("/console/words.en.js")).default;
let table = english;
if (wanted && /^[a-z]{2}$/.test(wanted) && wanted !== "en") {
  try {
    table = { ...english, ...(await import(`/console/words.${wanted}.js`)).default };
    document.documentElement.lang = wanted;
  } catch {
    // No such language: English.
  }
}

export { fixed } from "./numbers.js";

export const words = table;

/** Words of the program as a sentence's beginning: they begin in lower case. */
export const sentence = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** Fills the words into all elements that name one. */
export function fillWords() {
  for (const element of document.querySelectorAll("[data-word]")) element.textContent = words[element.dataset.word];
  for (const element of document.querySelectorAll("[data-label]")) element.setAttribute("aria-label", words[element.dataset.label]);
}
