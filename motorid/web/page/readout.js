// What the channels read: now, or at the two cursors and between them.

import { label } from "./strips.js";

const DASH = "–";

export function number(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return DASH;
  const size = Math.abs(value);
  const digits = size >= 1000 ? 0 : size >= 100 ? 1 : size >= 10 ? 2 : size >= 1 ? 3 : 4;
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

export class Readout {
  constructor(root) {
    this.root = root;
    this.kind = "";
  }

  show(store, cursors, view) {
    const [a, b] = [cursors.A, cursors.B];
    if (a === null && b === null) this.#table(["now", "mean", "min", "max"], this.#now(store, view), "");
    else if (a === null || b === null) this.#one(store, a ?? b, a === null ? "B" : "A");
    else this.#two(store, a, b);
  }

  #now(store, [from, to]) {
    return store.channels.map((_, c) => {
      const all = store.summary(c, from, to);
      const now = store.end ? store.value(c, store.end - 1) : NaN;
      return [now, all?.mean, all?.low, all?.high];
    });
  }

  #one(store, time, name) {
    this.#table([name], store.channels.map((_, c) => [store.at(c, time)]), `${name} at ${time.toFixed(5)} s`);
  }

  #two(store, a, b) {
    const [from, to] = [Math.min(a, b), Math.max(a, b)];
    const rows = store.channels.map((_, c) => {
      const [one, other] = [store.at(c, a), store.at(c, b)];
      const all = store.summary(c, from, to);
      return [one, other, other - one, all?.mean, all?.rms];
    });
    const step = b - a;
    const rate = step ? `, 1/Δt = ${number(1 / Math.abs(step))} Hz` : "";
    this.#table(["A", "B", "B − A", "mean", "RMS"], rows, `Δt = ${number(1e3 * step)} ms${rate}`);
  }

  #table(head, rows, note) {
    const kind = head.join();
    if (kind !== this.kind || this.rows?.length !== rows.length) this.#build(head, rows.length, kind);
    this.note.textContent = note;
    rows.forEach((row, r) => row.forEach((value, k) => { this.rows[r][k].textContent = number(value); }));
  }

  #build(head, count, kind) {
    this.kind = kind;
    const table = document.createElement("table"), top = table.createTHead().insertRow();
    for (const text of ["", ...head]) {
      const cell = document.createElement("th");
      cell.textContent = text;
      top.append(cell);
    }
    const body = table.createTBody();
    this.rows = Array.from({ length: count }, (_, r) => {
      const line = body.insertRow(), name = document.createElement("th");
      name.scope = "row";
      name.textContent = this.names?.[r] ?? "";
      line.append(name);
      return head.map(() => line.insertCell());
    });
    this.note = document.createElement("p");
    this.root.replaceChildren(table, this.note);
  }

  name(channels) {
    this.names = channels.map((one) => `${label(one)}, ${one.unit}`);
    this.kind = "";
  }
}
