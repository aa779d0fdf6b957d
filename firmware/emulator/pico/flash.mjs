// A Pico's flash chip behind the processor's interface for it: what firmware writes stays there over resets,
// takes its time, and is torn where power goes meanwhile.
import { BasePeripheral } from 'rp2040js';

const SIZE = 1 << 21;
const SECTOR = 4096;
const BLANK = 0xff;
const PROGRAM = 0x02;
const READ_STATUS = 0x05;
const ENABLE_WRITING = 0x06;
const ERASE_SECTOR = 0x20;
const READ_NUMBER = 0x4b; // and four bytes without a meaning
const NUMBER = [0xe6, 0x61, 0x41, 0x04, 0x03, 0x2b, 0x1c, 0x27];
const ERASE_NS = 45e6;
const PROGRAM_NS = 0.4e6;
const SELECT_CTRL = 0x0c; // of IO_QSPI
const BY_FORCE_LOW = 2;
const STATUS = 0x28; // of the interface
const DATA = 0x60;
const JOURNAL = 0x1fe000; // firmware/ports/rp2040/journal.c
const CAN_SEND = 0x6;
const HAS_RECEIVED = 0x8;

// Flash that holds these bytes, as the firmware's journal has them after it was first used.
export function keep(flash, bytes) {
  const doubled = (half) => (half | ((half ^ 0xffff) << 16)) >>> 0;
  const words = new DataView(flash.buffer, flash.byteOffset + JOURNAL, SECTOR);
  if (bytes.length > 0) words.setUint32(0, doubled(1), true);
  bytes.forEach((byte, at) => words.setUint32(4 * (at + 1), doubled((byte << 8) | at), true));
  return flash;
}

export class FlashChip {
  constructor(clock, bytes) {
    this.clock = clock;
    this.bytes = bytes;
    this.enabled = false; // a command may write
    this.busyUntil = 0;
    this.latest = null; // what it is busy with
    this.command = null;
  }

  get busy() {
    return this.clock.nanos < this.busyUntil;
  }

  select(on) {
    if (on && !this.command) this.command = [];
    if (!on && this.command) {
      const words = this.command;
      this.command = null;
      this.#take(words);
    }
  }

  // A byte in for a byte out.
  exchange(byte) {
    if (!this.command) return BLANK;
    this.command.push(byte);
    if (this.command[0] === READ_NUMBER) return NUMBER[this.command.length - 6] ?? BLANK;
    if (this.command[0] !== READ_STATUS || this.command.length < 2) return BLANK;
    return (this.busy ? 1 : 0) | (this.enabled ? 2 : 0);
  }

  #take([code, high, middle, low, ...data]) {
    if (this.busy) return;
    const at = ((high << 16) | (middle << 8) | low) % SIZE;
    if (code === ENABLE_WRITING) this.enabled = true;
    if (!this.enabled) return;
    if (code === ERASE_SECTOR) {
      this.#begin(at - (at % SECTOR), new Array(SECTOR).fill(BLANK), ERASE_NS);
    } else if (code === PROGRAM) {
      this.#begin(at, data.map((byte, n) => byte & this.bytes[at + n]), PROGRAM_NS);
    }
  }

  #begin(at, data, takes) {
    this.latest = { at, before: this.bytes.slice(at, at + data.length), after: data };
    this.bytes.set(data, at);
    this.busyUntil = this.clock.nanos + takes;
    this.enabled = false;
  }

  // Power goes: of what the chip is busy with any bits have changed, and others have not.
  losePower(random) {
    if (this.busy) {
      const { at, before, after } = this.latest;
      this.bytes.set(before.map((byte, n) => { const some = random() & BLANK; return (byte & ~some) | (after[n] & some); }), at);
    }
    this.busyUntil = this.clock.nanos;
    this.enabled = false;
    this.command = null;
  }
}

// Where the processor reaches it: an interface that takes bytes, and a pin that selects the chip.
export class FlashInterface extends BasePeripheral {
  constructor(chip, flash) {
    super(chip, 'SSI');
    this.flash = flash;
    this.received = [];
  }

  readUint32(offset) {
    if (offset === STATUS) return CAN_SEND | (this.received.length > 0 ? HAS_RECEIVED : 0);
    return offset === DATA ? (this.received.shift() ?? BLANK) : 0;
  }

  writeUint32(offset, value) {
    if (offset === DATA) this.received.push(this.flash.exchange(value & 0xff));
  }
}

export class FlashSelect extends BasePeripheral {
  constructor(chip, flash) {
    super(chip, 'IO_QSPI');
    this.flash = flash;
    this.ctrl = 0;
  }

  readUint32(offset) {
    return offset === SELECT_CTRL ? this.ctrl : 0;
  }

  writeUint32(offset, value) {
    if (offset !== SELECT_CTRL) return;
    this.ctrl = value;
    this.flash.select(((value >> 8) & 3) === BY_FORCE_LOW);
  }
}
