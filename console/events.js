// The event log: the events of the last hour, newest first.

const MAX_ROWS = 300;

export class EventList {
  #list = document.getElementById("events");

  /** Shows all events anew. */
  reset(events) {
    this.#list.replaceChildren();
    for (const event of events.slice(-MAX_ROWS)) this.add(event);
  }

  add({ unix_ms: at, level, text }) {
    const row = document.createElement("li");
    const time = new Date(at).toLocaleTimeString();
    row.textContent = `${time}  ${level === "info" ? "" : level === "alarm" ? "⚠ " : "! "}${text}`;
    row.dataset.level = level;
    this.#list.prepend(row);
    while (this.#list.children.length > MAX_ROWS) this.#list.lastElementChild.remove();
  }
}
