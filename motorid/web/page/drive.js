// The buttons that drive, where the program allows it. While one runs, the page says that it is there.

const BEATS = 10; // in the silence after which the program stops the motor

export class Drive {
  constructor(root, link) {
    this.root = root;
    this.link = link;
    this.timer = null;
    const by = (name) => root.querySelector(`[data-do="${name}"]`);
    this.buttons = [by("program"), by("pulse")];
    by("program").onclick = () => this.press({ what: "program" });
    by("pulse").onclick = () => this.press({
      what: "pulse",
      volts: root.querySelector("[name=volts]").valueAsNumber,
      seconds: root.querySelector("[name=seconds]").valueAsNumber,
    });
    by("stop").onclick = () => this.stop();
  }

  status({ drive, state, said }) {
    this.root.hidden = !drive;
    if (!drive) return;
    this.silence = drive.silence_s;
    this.root.querySelector("[data-do=program]").title = `${drive.program_s.toFixed(2)} s`;
    const running = state === "driving";
    for (const button of this.buttons) button.disabled = running;
    const ended = said !== this.said && !running && (state !== "watching" || this.running);
    if (ended) this.rest();
    [this.said, this.running] = [said, running];
  }

  press(what) {
    this.link.ask({ ask: "press", ...what });
    this.rest();
    this.timer = setInterval(() => this.link.ask({ ask: "beat" }), 1e3 * this.silence / BEATS);
  }

  stop() {
    this.link.ask({ ask: "stop" });
  }

  rest() {
    clearInterval(this.timer);
    this.timer = null;
  }
}
