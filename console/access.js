// Access: exchanges the token of the link for a cookie, and asks for a token where there is none.

const TOKEN_IN_LINK = /[#&]token=([^&]+)/;

/** The name of this page, which a reload keeps. */
export function pageName() {
  let name = sessionStorage.getItem("page");
  if (!name) {
    name = [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
    sessionStorage.setItem("page", name);
  }
  return name;
}

/** Logs in with a token. @param {string} token @returns {Promise<boolean>} */
async function logIn(token) {
  const headers = { Authorization: `Bearer ${token}` };
  const response = await fetch("/api/v1/login", { method: "POST", headers }).catch(() => null);
  return response !== null && response.ok;
}

/** Uses the token of the page's address, and removes it from there. Returns whether the page may go on. */
export async function enter() {
  const found = TOKEN_IN_LINK.exec(location.hash);
  if (found) {
    history.replaceState(null, "", location.pathname + location.search);
    await logIn(decodeURIComponent(found[1]));
  }
  for (;;) {
    const response = await fetch("/api/v1/access").catch(() => null);
    if (response) return response.ok;
    await new Promise((resolve) => setTimeout(resolve, 500));
  }
}

/** Asks for a token until one is accepted. @param {Record<string, any>} words */
export function askForToken(words) {
  const panel = document.getElementById("entry");
  for (const part of document.querySelectorAll("main, header")) part.hidden = true;
  panel.hidden = false;
  const field = /** @type {HTMLInputElement} */ (document.getElementById("token"));
  field.focus();
  return new Promise((resolve) => {
    document.getElementById("entry-form").addEventListener("submit", async (event) => {
      event.preventDefault();
      const text = field.value.trim();
      const found = TOKEN_IN_LINK.exec(text);
      if (await logIn(found ? decodeURIComponent(found[1]) : text)) {
        for (const part of document.querySelectorAll("main, header")) part.hidden = false;
        panel.hidden = true;
        resolve(undefined);
      } else {
        document.getElementById("entry-error").textContent = words.entryWrong;
      }
    });
  });
}
