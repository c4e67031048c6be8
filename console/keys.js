// The keyboard: which key presses which button, and which keys are held.

const BUTTONS = { t: "mark", u: "unmark", g: "guide", b: "stop-boat", c: "next-mark", y: "go-home", e: "engage", r: "disengage", z: "freeze", x: "reject", l: "search", j: "keep-size", p: "pause", h: "helmsman", k: "new-drive", n: "theme", m: "note", q: "sound", o: "candidates", v: "video", i: "level", f: "full-screen", "?": "keys", "+": "zoom-in", "-": "zoom-out", 0: "zoom-reset" };

/** Whether keys write text there. A checkbox takes none: Enter switches it. */
const takesText = (element) => element instanceof HTMLInputElement && element.type !== "checkbox";
const nameOf = ({ key }) => (key.length === 1 ? key.toLowerCase() : key);

/**
 * @param {{act: Record<string, () => void>, take: (number: number) => void, held: any[], onEscape: () => void}} options `held`: the
 *   controls with keys that are held; `take`: of a digit
 */
export function listenToKeys({ act, take, held, onEscape }) {
  // The name of a key changes with Shift, AltGr and Num Lock: its release has the name of its press, by its place on the keyboard.
  const down = new Map();
  const hold = (event) => {
    const key = nameOf(event);
    if (!held.some((control) => control.onKey(key, true))) return false;
    down.set(event.code || key, key);
    return true;
  };
  const letGo = (event) => {
    const place = event.code || nameOf(event);
    const key = down.get(place);
    if (key === undefined) return;
    down.delete(place);
    held.forEach((control) => control.onKey(key, false));
  };
  // A browser on a Mac does not tell that a key goes up while Meta is down: the key would be held for ever.
  const releaseWithMeta = (event) => (event.metaKey || event.key === "Meta") && held.forEach((control) => control.release());
  addEventListener("keydown", (event) => {
    releaseWithMeta(event);
    const isText = takesText(event.target);
    if (event.key === " " && !isText) {
      if (!event.repeat) act.stop();
      event.preventDefault();
      event.stopPropagation();
      return;
    }
    if (event.key === "Escape") onEscape();
    if (isText || event.ctrlKey || event.altKey || event.metaKey || event.target instanceof HTMLSelectElement) return;
    if (event.repeat) {
      // A key that was down when everything was let go holds nothing until it is pressed anew.
      if (down.has(event.code || nameOf(event))) event.preventDefault();
      return;
    }
    const key = nameOf(event);
    if (hold(event)) event.preventDefault();
    else if (/^[1-8]$/.test(key)) take(Number(key));
    else if (BUTTONS[key] && !document.getElementById(BUTTONS[key]).disabled) act[BUTTONS[key]]();
  });
  addEventListener("keyup", (event) => {
    releaseWithMeta(event);
    if (event.key === " " && !takesText(event.target)) event.preventDefault();
    letGo(event);
  });
}
