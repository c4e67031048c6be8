// Makes elements of the page.

/** An element with a text and attributes. @param {string} tag @param {string} text @param {Record<string, string>} attributes */
export function element(tag, text, attributes = {}) {
  const made = document.createElement(tag);
  made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
