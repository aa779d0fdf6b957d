// A USB host at an emulated Pico's plug: it finds a serial port there as a computer does, and moves at most 19
// packets of 64 bytes in each millisecond, some later than others. It takes nothing that the standard forbids.
const FRAME_NS = 1e6;
const SLOT_NS = 50e3;
const SLOTS = 19;
const RESET_NS = 10e6;
const ADDRESS_NS = 2e6; // that a device may take until it hears its new address
const PACKET = 64;
const FULL = 1 << 15;
const LATER = 1 << 13;
const STALL = 1 << 11;
const AVAILABLE = 1 << 10;
const LENGTH = 0x3ff;
const SETUP_REC = 1 << 17;
const BUS_RESET = 1 << 19;
const PULL_UP = 1 << 16;
const ENDPOINT_ON = 1 << 31;
const CONTROL_BUFFER = 0x100;
const PATIENCE = 400; // slots that a device may take for an answer
const ADDRESS = 5;

class Refused extends Error {}

export class UsbHost {
  constructor(chip) {
    this.chip = chip;
    this.memory = chip.usbDPRAMView;
    this.controller = chip.usbCtrl;
    this.controller.DPRAMUpdated = () => {}; // this host is in place of the emulator's
    this.toSend = [];
    this.received = []; // when, and the bytes
    this.later = { 0: false }; // names of the next packets, by endpoint, 0x80 to the host
    this.identity = null; // descriptors, once it is found
    this.seed = 1;
    this.slot = 0;
    this.work = this.#plugIn();
    this.alarm = chip.clock.createAlarm(() => this.#pass());
    this.alarm.schedule(FRAME_NS);
  }

  hear(bytes) {
    for (const byte of bytes) this.toSend.push(byte);
  }

  take(now) {
    let n = 0;
    while (n < this.received.length && this.received[n][0] <= now) n++;
    return Buffer.concat(this.received.splice(0, n).map(([, bytes]) => bytes));
  }

  // A slot of a frame; some frames begin late.
  #pass() {
    this.slot = (this.slot + 1) % SLOTS;
    const late = this.slot === 0 ? FRAME_NS - SLOTS * SLOT_NS + this.#random(3) * SLOT_NS : 0;
    this.alarm.schedule(SLOT_NS + late);
    if (this.work.next().done) throw new Error('the host has nothing more to do');
  }

  #random(below) {
    this.seed = (Math.imul(this.seed, 1664525) + 1013904223) >>> 0;
    return (this.seed >>> 16) % below;
  }

  #done(bit) {
    this.controller.buffStatus |= 1 << bit;
    this.controller.buffStatusUpdated();
  }

  #place(endpoint, out) {
    if (endpoint === 0) return CONTROL_BUFFER;
    const control = this.memory.getUint32(8 * endpoint + (out ? 4 : 0), true);
    if (!(control & ENDPOINT_ON)) throw new Error(`endpoint ${endpoint} is off`);
    return control & 0xffc0;
  }

  // A packet to the host; null where the device is not ready.
  #in(endpoint) {
    const at = 0x80 + 8 * endpoint;
    const control = this.memory.getUint32(at, true);
    if (endpoint === 0 && control & STALL) throw new Refused();
    if (!(control & AVAILABLE) || !(control & FULL)) return null;
    if (!!(control & LATER) !== this.later[0x80 | endpoint]) throw new Error(`endpoint ${endpoint}: a packet twice, or none`);
    this.later[0x80 | endpoint] = !this.later[0x80 | endpoint];
    const from = this.#place(endpoint, false);
    const bytes = Buffer.from(this.chip.usbDPRAM.slice(from, from + (control & LENGTH)));
    this.memory.setUint32(at, control & ~(AVAILABLE | FULL), true);
    this.#done(2 * endpoint);
    return bytes;
  }

  // A packet to the device; false where it is not ready.
  #out(endpoint, bytes) {
    const at = 0x84 + 8 * endpoint;
    const control = this.memory.getUint32(at, true);
    if (endpoint === 0 && control & STALL) throw new Refused();
    if (!(control & AVAILABLE)) return false;
    if (!!(control & LATER) !== this.later[endpoint]) throw new Error(`endpoint ${endpoint}: it expects another packet`);
    if (bytes.length > (control & LENGTH)) throw new Error(`endpoint ${endpoint}: its buffer is too short`);
    this.later[endpoint] = !this.later[endpoint];
    this.chip.usbDPRAM.set(bytes, this.#place(endpoint, true));
    this.memory.setUint32(at, (control & ~(AVAILABLE | LENGTH)) | FULL | bytes.length, true);
    this.#done(2 * endpoint + 1);
    return true;
  }

  *#until(what) {
    for (let n = 0; n < PATIENCE; n++) {
      const found = what();
      yield;
      if (found !== null && found !== false) return found;
    }
    throw new Error('the device does not answer');
  }

  *#rest(ns) {
    for (let past = 0; past < ns; past += SLOT_NS) yield;
  }

  *#setup(kind, request, value, index, length) {
    const { memory, controller } = this;
    [kind, request, value & 0xff, value >> 8, index & 0xff, index >> 8, length & 0xff, length >> 8].forEach((byte, n) =>
      memory.setUint8(n, byte),
    );
    for (const at of [0x80, 0x84]) memory.setUint32(at, 0, true);
    this.later[0] = this.later[0x80] = true;
    controller.sieStatus |= SETUP_REC;
    controller.sieStatusUpdated();
    yield;
  }

  *#ask(kind, request, value, index, length) {
    yield* this.#setup(kind, request, value, index, length);
    const parts = [];
    let size = 0;
    for (;;) {
      const part = yield* this.#until(() => this.#in(0));
      parts.push(part);
      size += part.length;
      if (part.length < PACKET || size >= length) break;
    }
    this.later[0] = true;
    yield* this.#until(() => this.#out(0, Buffer.alloc(0)));
    return Buffer.concat(parts);
  }

  *#tell(kind, request, value, index, data = Buffer.alloc(0)) {
    yield* this.#setup(kind, request, value, index, data.length);
    if (data.length > 0) yield* this.#until(() => this.#out(0, data));
    this.later[0x80] = true;
    const end = yield* this.#until(() => this.#in(0));
    if (end.length !== 0) throw new Error('the end of a transfer is an empty packet');
  }

  *#text(number) {
    const bytes = yield* this.#ask(0x80, 6, 0x300 | number, 0x409, 255);
    if (bytes[0] !== bytes.length || bytes[1] !== 3) throw new Error('a text of another length');
    return bytes.subarray(2).toString('utf16le');
  }

  // As the standard has it: reset, descriptors, address, configuration; then the class's line.
  *#plugIn() {
    while (!(this.controller.sieCtrl & PULL_UP)) yield;
    this.controller.sieStatus |= BUS_RESET;
    this.controller.sieStatusUpdated();
    yield* this.#rest(RESET_NS);
    yield* this.#ask(0x80, 6, 0x100, 0, 8);
    yield* this.#tell(0x00, 5, ADDRESS, 0);
    yield* this.#rest(ADDRESS_NS);
    if ((this.controller.addrEndp & 0x7f) !== ADDRESS) throw new Error('it does not take its address');
    const device = yield* this.#ask(0x80, 6, 0x100, 0, 18);
    const head = yield* this.#ask(0x80, 6, 0x200, 0, 9);
    const configuration = yield* this.#ask(0x80, 6, 0x200, 0, head.readUInt16LE(2));
    const texts = [];
    for (const number of [14, 15, 16]) texts.push(yield* this.#text(device[number]));
    try {
      yield* this.#ask(0x80, 6, 0x600, 0, 10); // of high speed, which it has not
      throw new Error('it answers what it has not');
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
    }
    yield* this.#tell(0x00, 9, configuration[5], 0);
    const line = Buffer.from([0x00, 0xc2, 0x01, 0, 0, 0, 8]);
    yield* this.#tell(0x21, 0x20, 0, 0, line);
    if (!(yield* this.#ask(0xa1, 0x21, 0, 0, 7)).equals(line)) throw new Error('it forgets its line');
    yield* this.#tell(0x21, 0x22, 3, 0);
    this.identity = { device, configuration, texts };
    yield* this.#carry(configuration);
  }

  *#carry(configuration) {
    const { from, to } = endpoints(configuration);
    this.later[0x80 | from] = this.later[to] = false;
    for (let turn = 0; ; turn++) {
      const sends = this.toSend.length > 0 && turn % 2 === 0;
      if (sends) {
        if (this.#out(to, Buffer.from(this.toSend.slice(0, PACKET)))) this.toSend.splice(0, PACKET);
      } else {
        const bytes = this.#in(from);
        if (bytes) this.received.push([this.chip.clock.nanos, bytes]);
      }
      yield;
    }
  }
}

// The two of the class of data.
function endpoints(configuration) {
  const found = {};
  for (let at = 0; at < configuration.length; at += configuration[at]) {
    const bulk = configuration[at + 1] === 5 && configuration[at + 3] === 2;
    if (bulk) found[configuration[at + 2] & 0x80 ? 'from' : 'to'] = configuration[at + 2] & 0x0f;
  }
  return found;
}
