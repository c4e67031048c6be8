// Who controls: shows it, and takes, asks for and gives the control.

import { openDialog } from "./dialogs.js";
import { toast } from "./status.js";
import { words } from "./words.js";

const at = (id) => document.getElementById(id);

export class ControlSeat {
  #own = null;
  #mayControl = true;
  #holder = undefined;
  isControlling = false;
  /** Whether this page asked for the control and waits. */
  hasAsked = false;

  /** Whether the page's link permits the control. */
  get mayControl() {
    return this.#mayControl;
  }

  /** Why this page, which does not control, may not do something. */
  get whyNot() {
    return this.#mayControl ? words.reasons.watcher : words.reasons.watchLink;
  }

  /** @param {import("./link.js").Link} link */
  constructor(link) {
    link.addEventListener("hello", ({ detail }) => {
      [this.#own, this.#mayControl, this.#holder] = [detail.client, detail.may_control, undefined];
    });
    link.addEventListener("control", ({ detail }) => this.#show(detail));
    const request = async (wanted) => {
      const { answer, reason } = await link.request(wanted);
      if (answer !== "accepted" && reason) toast(`${words.answers.refused}: ${reason}`);
    };
    this.give = (client) => request({ kind: "give-control", client });
    at("ask-control").addEventListener("click", () => request({ kind: "ask-control" }));
    at("take-control").addEventListener("click", () => {
      if (this.#holder === null) request({ kind: "take-control" });
      else openDialog(at("take-dialog"));
    });
    at("take-dialog").addEventListener("close", () => {
      if (at("take-dialog").returnValue === "take") request({ kind: "take-control" });
      at("take-dialog").returnValue = "";
    });
  }

  #show(seat) {
    const before = this.#holder;
    const nameOf = (client) => words.client(client, client === seat.program);
    const holder = nameOf(seat.holder);
    const was = this.isControlling;
    this.#holder = seat.holder;
    this.isControlling = seat.holder === this.#own && seat.holder_connected;
    if (was && !this.isControlling && seat.holder !== null) toast(words.took(holder), true);
    else if (!was && this.isControlling && before !== undefined) toast(words.gotControl);
    const text = !this.#mayControl ? words.mayWatch
      : this.isControlling ? words.youControl
      : seat.holder === null ? words.nobodyControls
      : seat.holder_connected ? words.youWatch(holder) : words.holderLost(holder);
    at("seat").textContent = text;
    this.hasAsked = !this.isControlling && seat.asking.includes(this.#own);
    at("ask-control").textContent = this.hasAsked ? words.askedControl : words.askControl;
    const asking = this.isControlling ? seat.asking.filter((client) => client !== this.#own) : [];
    at("asking").replaceChildren(...asking.map((client) => {
      const [row, button, text] = ["p", "button", "span"].map((name) => document.createElement(name));
      text.textContent = words.asks(nameOf(client));
      button.textContent = words.giveControl(nameOf(client));
      button.dataset.give = client;
      button.addEventListener("click", () => this.give(client));
      row.append(text, button);
      return row;
    }));
  }
}
