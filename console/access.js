// Access: exchanges the token of the link for a cookie, and asks for a token where there is none.

const TOKEN_IN_LINK = /[#&]token=([^&]+)/;

/** How long another tab may take to say that it has a name already, ms. */
const NAME_WAIT_MS = 60;

/** How long the program may take to say whether the page may enter, ms. After a change of network an answer may never come. */
const ACCESS_TIMEOUT_MS = 2000;

/** The name of this page. A reload keeps it; a duplicated tab, which begins with a copy of the name, gets its own. */
export let pageName = "";

function newName() {
  return [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** Chooses the name of this page, and answers other tabs that begin with the same one. */
async function chooseName() {
  const tabs = new BroadcastChannel("barrelman-pages");
  const wanted = sessionStorage.getItem("page");
  let isTaken = !wanted;
  if (wanted) {
    tabs.onmessage = ({ data }) => (isTaken ||= data.has === wanted);
    tabs.postMessage({ asks: wanted });
    await new Promise((resolve) => setTimeout(resolve, NAME_WAIT_MS));
  }
  pageName = isTaken ? newName() : wanted;
  sessionStorage.setItem("page", pageName);
  tabs.onmessage = ({ data }) => data.asks === pageName && tabs.postMessage({ has: pageName });
}

/** Whether the program accepts this page's token; `null` where the program cannot be reached. */
export async function mayEnter() {
  const signal = AbortSignal.timeout(ACCESS_TIMEOUT_MS);
  const response = await fetch("/api/v1/access", { signal }).catch(() => null);
  return response && (response.ok || response.status !== 401);
}

/** Logs in with a token; `null` where the program cannot be reached. @param {string} token @returns {Promise<boolean | null>} */
async function logIn(token) {
  const headers = { Authorization: `Bearer ${token}` };
  const response = await fetch("/api/v1/login", { method: "POST", headers }).catch(() => null);
  return response && response.ok;
}

/**
 * Uses the token of the page's address, and removes it from there.
 * @returns {Promise<"open" | "none" | "wrong">} whether the page may go on; otherwise whether it came with a token
 */
export async function enter() {
  // A link that is opened in a tab with this page changes its address, and loads nothing.
  addEventListener("hashchange", () => {
    if (TOKEN_IN_LINK.test(location.hash)) location.reload();
  });
  const found = TOKEN_IN_LINK.exec(location.hash);
  let isWrong = false;
  if (found) {
    history.replaceState(null, "", location.pathname + location.search);
    isWrong = (await logIn(decodeURIComponent(found[1]))) === false;
  }
  await chooseName();
  for (;;) {
    const isPermitted = await mayEnter();
    if (isPermitted !== null) return isPermitted ? "open" : isWrong ? "wrong" : "none";
    await new Promise((resolve) => setTimeout(resolve, 500));
  }
}

/** Lets a page whose token was renewed without it stop all the same. */
async function offerStop(words) {
  const response = await fetch("/api/v1/access", { signal: AbortSignal.timeout(ACCESS_TIMEOUT_MS) }).catch(() => null);
  const { may_stop: mayStop } = (await response?.json().catch(() => null)) ?? {};
  const button = document.getElementById("entry-stop");
  button.hidden = !mayStop;
  button.onclick = async () => {
    const body = JSON.stringify({ request: { kind: "stop" } });
    const stop = { method: "POST", headers: { "Content-Type": "application/json" }, body, signal: AbortSignal.timeout(ACCESS_TIMEOUT_MS) };
    const answer = await fetch("/api/v1/requests", stop).then((sent) => sent.json()).catch(() => null);
    document.getElementById("entry-error").textContent = answer?.answer === "accepted" ? words.entryStopped : words.entryNotStopped;
  };
}

/** Asks for a token until one is accepted. @param {Record<string, any>} words @param {"none" | "wrong"} why */
export function askForToken(words, why) {
  const title = document.title;
  document.title = words.entryPage;
  document.getElementById("entry-error").textContent = why === "wrong" ? words.linkWrong : "";
  const panel = document.getElementById("entry");
  for (const part of document.querySelectorAll("main, header")) part.hidden = true;
  panel.hidden = false;
  offerStop(words);
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
        document.title = title;
        resolve(undefined);
      } else {
        document.getElementById("entry-error").textContent = words.entryWrong;
      }
    });
  });
}
