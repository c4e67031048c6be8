// Other devices: the links that open the page there, the pages that are open, and how they are signed out.

import { openDialog } from "./dialogs.js";
import { element } from "./elements.js";
import { toast } from "./status.js";
import { words } from "./words.js";

const LINKS = "/api/v1/links";
const LOOPBACK = ["localhost", "127.0.0.1", "[::1]"];
const at = (id) => document.getElementById(id);

export class Devices {
  #own = null;
  #mayControl = false;
  #seat = { clients: [] };
  /** How often the codes were shown: a browser keeps no code of earlier links. */
  #shown = 0;

  /** @param {import("./link.js").Link} link */
  constructor(link) {
    link.addEventListener("hello", ({ detail }) => {
      [this.#own, this.#mayControl] = [detail.client, detail.may_control];
      at("devices").disabled = !this.#mayControl;
      at("devices").title = this.#mayControl ? "" : words.reasons.watchLink;
    });
    link.addEventListener("control", ({ detail }) => {
      this.#seat = detail;
      this.#showPages();
    });
    at("new-links").addEventListener("click", () => this.#renew());
  }

  /** Opens the dialog. */
  open() {
    at("keys-dialog").close();
    this.#showPages();
    this.#showLinks();
    openDialog(at("devices-dialog"));
  }

  async #showLinks() {
    const isHere = LOOPBACK.includes(location.hostname);
    at("devices-here").hidden = !isHere;
    at("device-links").hidden = isHere;
    if (isHere) return;
    const links = await answerOf(fetch(LINKS));
    if (!links) return;
    this.#shown += 1;
    for (const name of ["control", "watch"]) {
      at(`code-${name}`).src = `${LINKS}/${name}.svg?${this.#shown}`;
      at(`link-${name}`).textContent = links[name];
    }
  }

  #showPages() {
    const others = this.#seat.clients.filter((id) => id !== this.#own && id !== this.#seat.program);
    at("pages").replaceChildren(...others.map((id) => {
      const row = element("li", words.client(id, false));
      const button = element("button", words.signOut);
      button.dataset.page = id;
      button.addEventListener("click", () => answerOf(fetch(`/api/v1/pages/${id}`, { method: "DELETE" })));
      row.append(" ", button);
      return row;
    }));
    at("no-pages").hidden = others.length > 0;
  }

  async #renew() {
    const renewed = await answerOf(fetch(LINKS, { method: "POST" }));
    if (!renewed) return;
    toast(renewed.warning ?? words.linksRenewed);
    this.#showLinks();
  }
}

/** What a request answers; a refusal is shown, and is `null`. @param {Promise<Response>} request */
async function answerOf(request) {
  const response = await request.catch(() => null);
  if (response?.ok) return response.status === 204 ? {} : response.json();
  const reason = response ? (await response.text()).trim() : words.reasons.notConnected;
  toast(`${words.answers.refused}: ${reason}`);
  return null;
}
