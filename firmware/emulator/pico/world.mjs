// The rig, a stretch of PWM periods at a time: what is on the converter's inputs and on the encoder's lines.
// pico_rig.c has the other end, and says why a stretch is asked for before it passes.
import fs from 'node:fs';

const HEARS = 3;
const ASKS = 4;
const CYCLE_NS = 8;
const PERIOD_NS = 50_000;
const CONVERSION_NS = 2_000;
const INPUTS = 3;
const LONG = 20; // periods of a stretch, where the bridge does the same for long
const SHORT = 3; // and where it changes with each sample
const STRETCH_BYTES = 60;
export const LOW = [0, 0];
const OFF = { a: LOW, b: LOW, enable: false };

function equal(one, other) {
  return one.enable === other.enable && [0, 1].every((n) => one.a[n] === other.a[n] && one.b[n] === other.b[n]);
}

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
    tell(Buffer.from('N'));
    this.begin = 0; // of the stretch that is known, and its end
    this.end = 0;
    this.inputs = OFF; // of the driver: in the stretch; ticks of a period between which one is high
    this.cut = -1; // when all of them fell within it
    this.first = 0; // conversion of it: when, of which input, the codes
    this.input = 0;
    this.converts = false;
    this.codes = [];
    this.edges = []; // that are to come: when, and the count
  }

  // A period begins: the driver's inputs do this in it; conversions go on as they did, if they do.
  period(now, inputs, converts) {
    if (now < this.end && equal(inputs, this.shown) && converts === this.codes.length > 0) return;
    const cutShort = now < this.end;
    if (cutShort) {
      this.end = now;
      this.#ask('B', now);
    }
    if (converts) {
      const since = Math.ceil((now - this.first) / CONVERSION_NS);
      this.input = (this.input + since) % INPUTS;
      this.first += since * CONVERSION_NS;
    }
    const end = now + PERIOD_NS * (cutShort ? SHORT : LONG);
    Object.assign(this, { begin: now, end, inputs, converts, cut: -1 });
    this.#ask('P', -1);
  }

  // The driver's inputs as they are now.
  get shown() {
    return this.cut < 0 ? this.inputs : OFF;
  }

  get active() {
    return !equal(this.shown, OFF);
  }

  // All inputs fall now, or have gone with a reset. The stretch ends with its period.
  open(now) {
    if (!this.active) return;
    if (now < this.end) {
      this.cut = now;
      this.#shorten(now);
    } else {
      this.inputs = OFF;
    }
  }

  // The code of a conversion that begins now.
  code(now, input) {
    const n = (now - this.first) / CONVERSION_NS;
    if (this.codes.length === 0 || !Number.isInteger(n) || n < 0 || n >= this.codes.length) {
      Object.assign(this, { first: now, input, converts: true });
      this.#ask('B', now);
      return this.codes[0] ?? 0;
    }
    return this.codes[n];
  }

  set(text, now) {
    if (now < this.end) this.#shorten(now);
    const bytes = Buffer.from(text);
    const head = Buffer.from('S....');
    head.writeUInt32LE(bytes.length, 1);
    tell(Buffer.concat([head, bytes]));
  }

  facts(now) {
    const request = Buffer.alloc(9);
    request.write('G');
    request.writeDoubleLE(now / CYCLE_NS, 1);
    tell(request);
    return JSON.parse(take(take(4).readUInt32LE()).toString());
  }

  #shorten(now) {
    this.end = this.begin + Math.ceil((now + 1 - this.begin) / PERIOD_NS) * PERIOD_NS;
    this.#ask('B', now);
  }

  // Edges up to `past` have been shown.
  #ask(kind, past) {
    const conversions = this.converts ? Math.max(0, Math.ceil((this.end - this.first) / CONVERSION_NS)) : 0;
    const request = Buffer.alloc(1 + STRETCH_BYTES + 4);
    let at = request.write(kind);
    for (const ns of [this.begin, this.end]) at = request.writeDoubleLE(ns / CYCLE_NS, at);
    at = request.writeDoubleLE(this.cut < 0 ? -1 : this.cut / CYCLE_NS, at);
    at = request.writeDoubleLE(this.first / CYCLE_NS, at);
    const { a, b, enable } = this.inputs;
    for (const number of [...a, ...b, enable ? 1 : 0, conversions, this.input]) {
      at = request.writeInt32LE(number, at);
    }
    tell(request);
    const counts = take(8);
    this.#hear(take(counts.readUInt32LE(4) * EDGE_BYTES), take(conversions * 2));
    this.edges = this.edges.filter(([when]) => when > past);
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
