// Strips over two minutes: P, commands, confidence, delay. Drawn at most five times a second.

import { fixed } from "./numbers.js";

const SPAN_MS = 120_000;
const TOP_P = 2.5;
/** Both ways together, rad/s. */
const TOP_RATE = 0.8;
const TOP_DELAY_MS = 500;

/** The strips, from the top. `range`: what a strip's height stands for; `map`: a value as a share of the height. */
function rowsOf(words, colour) {
  return [
    { name: words.p, range: `0 – ${TOP_P}`, digits: 2, share: 0.4, lines: [["schemaP", colour("--dim"), 1.5, [4, 4]], ["p", colour("--accent"), 2.5, []]], map: (v) => Math.min(v, TOP_P) / TOP_P, mark: 1 / TOP_P },
    { name: words.command, range: `±${TOP_RATE / 2}`, digits: 2, share: 0.24, lines: [["pan", colour("--accent"), 2, []], ["tilt", colour("--warm"), 2, [6, 3]]], map: (v) => 0.5 + v / TOP_RATE, mark: 0.5 },
    { name: words.confidence, range: "0 – 1", digits: 2, share: 0.18, lines: [["confidence", colour("--good"), 2, []]], map: (v) => v, mark: null },
    { name: words.delay, range: `0 – ${TOP_DELAY_MS}`, digits: 0, share: 0.18, lines: [["delay", colour("--ink"), 2, []]], map: (v) => Math.min(v, TOP_DELAY_MS) / TOP_DELAY_MS, mark: null },
  ];
}

export class Strips {
  #samples = [];

  /** @param {HTMLCanvasElement} canvas @param {Record<string, string>} words @param {() => number} nowMs the time at the right end */
  constructor(canvas, words, nowMs = () => performance.now()) {
    [this.canvas, this.words, this.nowMs] = [canvas, words, nowMs];
    setInterval(() => this.#draw(), 200);
  }

  clear() {
    this.#samples = [];
  }

  /** Adds the state of now; at most 20 samples a second are kept. A time before the last one begins anew. */
  add(snapshot, delayMs) {
    const at = this.nowMs();
    const last = this.#samples.at(-1)?.at ?? -Infinity;
    if (at < last) this.clear();
    else if (at - last < 50) return;
    this.#samples.push({
      at,
      p: snapshot.percept?.p ?? null,
      schemaP: snapshot.work?.schema_p ?? null,
      pan: snapshot.command.pan,
      tilt: snapshot.command.tilt,
      confidence: snapshot.track.confidence,
      delay: delayMs,
    });
    while (at - this.#samples[0].at > SPAN_MS) this.#samples.shift();
  }

  #draw() {
    const { canvas } = this;
    const unit = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(canvas.clientWidth * unit), Math.round(canvas.clientHeight * unit)];
    if (!width || !height) return;
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const pen = canvas.getContext("2d");
    pen.clearRect(0, 0, width, height);
    const rows = rowsOf(this.words, colour).filter(({ name }) => name);
    const whole = rows.reduce((sum, { share }) => sum + share, 0);
    const now = this.nowMs();
    const x = (at) => width * (1 - (now - at) / SPAN_MS);
    let top = 0;
    for (const row of rows) {
      const rowHeight = (row.share / whole) * height;
      const y = (value) => top + rowHeight * (0.94 - 0.88 * Math.min(1, Math.max(0, row.map(value))));
      pen.strokeStyle = colour("--line");
      pen.lineWidth = unit;
      pen.setLineDash([]);
      pen.beginPath();
      pen.moveTo(0, top + rowHeight - 0.5);
      pen.lineTo(width, top + rowHeight - 0.5);
      pen.stroke();
      if (row.mark !== null) {
        const markY = top + rowHeight * (0.94 - 0.88 * row.mark);
        pen.strokeStyle = row.name === this.words.p ? colour("--alarm") : colour("--line");
        pen.setLineDash([6 * unit, 5 * unit]);
        pen.beginPath();
        pen.moveTo(0, markY);
        pen.lineTo(width, markY);
        pen.stroke();
      }
      for (const [key, ink, lineWidth, dash] of row.lines) {
        [pen.strokeStyle, pen.lineWidth] = [ink, lineWidth * unit];
        pen.setLineDash(dash.map((length) => length * unit));
        pen.beginPath();
        let isDown = false;
        for (const sample of this.#samples) {
          const value = sample[key];
          if (value === null || value === undefined) isDown = false;
          else if (isDown) pen.lineTo(x(sample.at), y(value));
          else {
            pen.moveTo(x(sample.at), y(value));
            isDown = true;
          }
        }
        pen.stroke();
      }
      pen.setLineDash([]);
      pen.fillStyle = colour("--dim");
      pen.font = `${12 * unit}px system-ui, sans-serif`;
      pen.fillText(`${row.name}: ${row.range}`, 4 * unit, top + 13 * unit);
      // The newest values, each in the colour of its curve.
      let right = width - 4 * unit;
      pen.textAlign = "right";
      pen.font = `700 ${13 * unit}px system-ui, sans-serif`;
      for (const [key, ink] of [...row.lines].reverse()) {
        const value = this.#samples.at(-1)?.[key] ?? null;
        const text = value === null ? "–" : fixed(value, row.digits);
        pen.fillStyle = ink;
        pen.fillText(text, right, top + 14 * unit);
        right -= pen.measureText(text).width + 10 * unit;
      }
      pen.textAlign = "start";
      top += rowHeight;
    }
  }
}
