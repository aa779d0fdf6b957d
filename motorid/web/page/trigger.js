// An edge of one channel that the view stands by, as on an oscilloscope.

export const OFF = "off", AUTO = "auto", NORMAL = "normal", SINGLE = "single";

export class Trigger {
  constructor() {
    this.mode = OFF;
    this.channel = 0;
    this.level = 0;
    this.rising = true;
    this.before = 0.25; // share of the view that lies before the edge
    this.arm();
  }

  // Looks only at what comes from now on.
  arm(store) {
    this.next = store ? store.end : 0;
    this.ready = false; // whether the signal has been on the far side of the level
    this.pending = null; // an edge whose view is not complete yet
    this.shown = null; // the latest edge whose view is
  }

  // Looks at the new samples; `span` is the length of the view in s, `noise` a step that is no edge.
  scan(store, span, noise) {
    if (this.mode === OFF || (this.mode === SINGLE && this.shown !== null)) return;
    const sign = this.rising ? 1 : -1, after = span * (1 - this.before);
    for (let i = Math.max(this.next, store.first + 1); i < store.end; i++) {
      const above = sign * (store.value(this.channel, i) - this.level), time = store.time(i);
      if (this.pending !== null && time >= this.pending + after) {
        this.shown = this.pending;
        this.pending = null;
        if (this.mode === SINGLE) break;
      }
      if (above < -noise) this.ready = true;
      else if (above >= 0 && this.ready) {
        this.ready = false;
        if (this.pending === null) this.pending = this.#crossing(store, i);
      }
    }
    this.next = store.end;
  }

  #crossing(store, i) {
    const before = store.value(this.channel, i - 1), now = store.value(this.channel, i);
    const share = now === before ? 0 : (now - this.level) / (now - before);
    const step = store.time(i) - store.time(i - 1);
    return store.time(i) - step * Math.min(Math.max(share || 0, 0), 1);
  }

  // The view by the trigger: [from, to]; null where the view follows the newest sample.
  view(store, span) {
    if (this.mode === OFF || this.shown === null) return null;
    const patience = Math.max(1, 2 * span);
    if (this.mode === AUTO && store.newest - this.shown > patience + span) return null;
    const from = this.shown - span * this.before;
    return [from, from + span];
  }
}
