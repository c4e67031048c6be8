// Sounds of alarms and of changes of mode; off until the operator wants them.

const TONES = { alarm: [880, 660, 880], good: [660, 880], stop: [330] };

export class Sounds {
  isOn = false;
  #context = null;

  toggle() {
    this.isOn = !this.isOn;
    if (this.isOn) this.#context ??= new AudioContext();
    this.play("good");
  }

  /** @param {keyof typeof TONES} name */
  play(name) {
    if (!this.isOn || !this.#context) return;
    const context = this.#context;
    TONES[name].forEach((frequency, index) => {
      const from = context.currentTime + 0.16 * index;
      const [tone, volume] = [context.createOscillator(), context.createGain()];
      tone.frequency.value = frequency;
      volume.gain.setValueAtTime(0.2, from);
      volume.gain.exponentialRampToValueAtTime(0.001, from + 0.15);
      tone.connect(volume).connect(context.destination);
      tone.start(from);
      tone.stop(from + 0.15);
    });
  }
}
