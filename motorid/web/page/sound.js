// A sound for each outcome, told apart without looking: two rising tones, one low, three short.

const TONES = {
  PASS: [[660, 0, 0.14], [880, 0.16, 0.22]],
  FAIL: [[196, 0, 0.7]],
  INVALID: [[440, 0, 0.12], [440, 0.2, 0.12], [440, 0.4, 0.12]],
};

export class Sound {
  constructor(button, text) {
    this.button = button;
    this.text = text;
    this.wanted = localStorage.getItem("motorid sound") !== "off";
    this.played = []; // for who looks from outside
    button.onclick = () => this.set(!this.wanted);
    // a browser lets a page sound only after a hand has touched it
    for (const kind of ["pointerdown", "keydown"]) addEventListener(kind, () => this.#wake(), { once: true });
  }

  set(wanted) {
    this.wanted = wanted;
    localStorage.setItem("motorid sound", wanted ? "on" : "off");
    this.#wake();
    this.show();
  }

  show() {
    this.button.textContent = this.text()[this.wanted ? "soundOn" : "soundOff"];
    this.button.setAttribute("aria-pressed", String(this.wanted));
  }

  play(word) {
    if (!this.wanted || !TONES[word]) return;
    this.played.push(word);
    if (!this.context || this.context.state !== "running") return;
    for (const [pitch, after, length] of TONES[word]) this.#tone(pitch, this.context.currentTime + after, length);
  }

  #wake() {
    this.context ??= new AudioContext();
    this.context.resume();
  }

  #tone(pitch, start, length) {
    const tone = this.context.createOscillator(), loud = this.context.createGain();
    tone.frequency.value = pitch;
    loud.gain.setValueAtTime(0.25, start);
    loud.gain.exponentialRampToValueAtTime(0.001, start + length);
    tone.connect(loud).connect(this.context.destination);
    tone.start(start);
    tone.stop(start + length);
  }
}
