// The rig, a PWM period at a time: what is on the converter's inputs and on the encoder's lines.
// pico_rig.c has the other end, and says why a period is asked for before it passes.
import fs from 'node:fs';

const HEARS = 3;
const ASKS = 4;
const CYCLE_NS = 8;
const PERIOD_NS = 50_000;
const CONVERSION_NS = 2_000;
const INPUTS = 3;
const PERIOD_BYTES = 52;
const EDGE_BYTES = 16;

function take(size) {
  const buffer = Buffer.alloc(size);
  let have = 0;
  while (have < size) {
    const count = fs.readSync(HEARS, buffer, have, size - have, null);
    if (count === 0) process.exit(1);
    have += count;
  }
  return buffer;
}

function tell(buffer) {
  let done = 0;
  while (done < buffer.length) done += fs.writeSync(ASKS, buffer, done);
}

export class World {
  constructor() {
    this.begin = 0; // of the period that is known, and its end
    this.end = 0;
    this.levels = [0, 0];
    this.enabled = false;
    this.cut = -1; // when enable fell within it
    this.first = 0; // conversion of it: when, of which input, the codes
    this.input = 0;
    this.codes = [];
    this.edges = []; // when, and the count
  }

  // The next one begins: the bridge does this in it; conversions go on as they did, if they do.
  period(now, levels, enabled, converts) {
    if (converts) {
      const since = Math.ceil((now - this.first) / CONVERSION_NS);
      this.input = (this.input + since) % INPUTS;
      this.first += since * CONVERSION_NS;
    }
    Object.assign(this, { begin: now, end: now + PERIOD_NS, levels, enabled, cut: -1 });
    this.#ask('P', converts);
  }

  // Enable falls now, or has gone with a reset.
  open(now) {
    if (this.enabled && this.cut < 0 && now < this.end) {
      this.cut = now;
      this.#ask('B', this.codes.length > 0);
    }
    this.enabled = false;
  }

  // The code of a conversion that begins now.
  code(now, input) {
    const n = (now - this.first) / CONVERSION_NS;
    if (this.codes.length === 0 || !Number.isInteger(n) || n < 0 || n >= this.codes.length) {
      this.first = now;
      this.input = input;
      this.#ask('B', true);
      return this.codes[0] ?? 0;
    }
    return this.codes[n];
  }

  set(text) {
    const bytes = Buffer.from(text);
    const head = Buffer.from('S....');
    head.writeUInt32LE(bytes.length, 1);
    tell(Buffer.concat([head, bytes]));
  }

  facts() {
    tell(Buffer.from('G'));
    return JSON.parse(take(take(4).readUInt32LE()).toString());
  }

  #ask(kind, converts) {
    const conversions = converts ? Math.max(0, Math.ceil((this.end - this.first) / CONVERSION_NS)) : 0;
    const request = Buffer.alloc(1 + PERIOD_BYTES + 4);
    let at = request.write(kind);
    for (const ns of [this.begin, this.end]) at = request.writeDoubleLE(ns / CYCLE_NS, at);
    at = request.writeDoubleLE(this.cut < 0 ? -1 : this.cut / CYCLE_NS, at);
    at = request.writeDoubleLE(this.first / CYCLE_NS, at);
    const driven = this.enabled || this.cut >= 0;
    for (const number of [...this.levels, driven ? 1 : 0, conversions, this.input]) {
      at = request.writeInt32LE(number, at);
    }
    tell(request);
    const counts = take(8);
    this.#hear(take(counts.readUInt32LE(4) * EDGE_BYTES), take(conversions * 2));
  }

  #hear(edges, codes) {
    this.edges = [];
    for (let at = 0; at < edges.length; at += EDGE_BYTES) {
      this.edges.push([edges.readDoubleLE(at) * CYCLE_NS, edges.readInt32LE(at + 8)]);
    }
    this.codes = [];
    for (let at = 0; at < codes.length; at += 2) this.codes.push(codes.readUInt16LE(at));
  }
}
