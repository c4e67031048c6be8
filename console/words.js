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

export const words = table;

/** Fills the words into all elements that name one. */
export function fillWords() {
  for (const element of document.querySelectorAll("[data-word]")) element.textContent = words[element.dataset.word];
  for (const element of document.querySelectorAll("[data-label]")) element.setAttribute("aria-label", words[element.dataset.label]);
}
