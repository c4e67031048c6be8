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
    const key = nameOf(event);
    if (held.some((control) => control.onKey(key, true))) event.preventDefault();
    else if (!event.repeat && /^[1-8]$/.test(key)) take(Number(key));
    else if (!event.repeat && BUTTONS[key] && !document.getElementById(BUTTONS[key]).disabled) act[BUTTONS[key]]();
  });
  addEventListener("keyup", (event) => {
    releaseWithMeta(event);
    if (event.key === " " && !takesText(event.target)) event.preventDefault();
    const key = nameOf(event);
    held.some((control) => control.onKey(key, false));
  });
}
