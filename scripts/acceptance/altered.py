"""A page whose messages from the program are changed on their way, so that every state can be seen."""

import pathlib
from typing import Any

from client import Program
from machine import wait_until
from page import Page

# Between the socket and the page. `alter` also delivers the first message and the seats again, as both come
# once. `drops`: nothing, "video" or "all".
HOOK = """
window.altered = { drops: "" };
const last = {};
let own = null;
const merge = (into, changes) => {
  for (const [key, value] of Object.entries(changes ?? {})) {
    const isNested = value && typeof value === "object" && !Array.isArray(value) && into[key];
    if (isNested) merge(into[key], value);
    else into[key] = value;
  }
  return into;
};
window.WebSocket = class extends WebSocket {
  set onmessage(handler) {
    const deliver = (data) => {
      const message = JSON.parse(data);
      // The page has the control, also where a busy machine lost it.
      if (message.type === "control") merge(message, { holder: own, holder_connected: true, asking: [] });
      merge(message, window.altered[message.type]);
      if (message.type === "hello") own = message.client;
      handler({ data: JSON.stringify(message) });
    };
    window.alter = (changes) => {
      window.altered = changes;
      for (const type of ["hello", "control"]) if (last[type]) deliver(last[type]);
    };
    super.onmessage = ({ data }) => {
      const isVideo = typeof data !== "string";
      if (window.altered.drops === "all" || (window.altered.drops === "video" && isVideo)) return;
      if (isVideo) return handler({ data });
      last[JSON.parse(data).type] = data;
      deliver(data);
    };
  }
};
"""


class AlteredPage(Page):
    """A page to which changed snapshots, seats and first messages are told."""

    def __init__(self, program: Program, folder: pathlib.Path, name: str = "altered") -> None:
        super().__init__(program.url, folder, name, before=HOOK)
        self.program = program
        self.ready()
        self.wait(lambda data: data["controlling"] == "yes", "the control")

    def alter(self, changes: dict[str, Any], shown: str) -> None:
        """Changes the messages from now on, and waits until `shown`, of the page's data `d`, is true."""
        self.script("window.alter(arguments[0])", {"drops": "", **changes})
        script = f"const d = document.documentElement.dataset; return Boolean({shown})"
        wait_until(lambda: self.script(script), lambda: f"{shown} ({self.data})")
        # What the page was told is drawn.
        self.driver.execute_async_script(
            "requestAnimationFrame(() => requestAnimationFrame(arguments[arguments.length - 1]))"
        )
