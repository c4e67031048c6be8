// The event log: the events of the last hour, newest first.

const MAX_ROWS = 300;

export class EventList {
  #list = document.getElementById("events");
  startUnixMs = 0;

  /** Shows all events anew. */
  reset(events) {
    this.#list.replaceChildren();
    for (const event of events.slice(-MAX_ROWS)) this.add(event);
  }

  add({ at_ns: at, level, text }) {
    const row = document.createElement("li");
    const time = new Date(this.startUnixMs + at / 1e6).toLocaleTimeString();
    row.textContent = `${time}  ${level === "info" ? "" : level === "alarm" ? "⚠ " : "! "}${text}`;
    row.dataset.level = level;
    this.#list.prepend(row);
    while (this.#list.children.length > MAX_ROWS) this.#list.lastElementChild.remove();
  }
}
