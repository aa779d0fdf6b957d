// An emulated Pico for another process: node pico.mjs IMAGE.uf2 uart|usb FACTS, started by pico_rig (see there).
// FACTS: the slot of a front end that its flash holds, in hex; empty: the chip is blank but for the image.
// The protocol on standard input and output is that of ../main.c. Time moves only while a request
// asks for it, so equal requests give equal answers.
import fs from 'node:fs';
import { RP2040 } from 'rp2040js';
import { Chip, load } from './chip.mjs';
import { FlashChip, keep } from './flash.mjs';
import { UsbHost } from './usb.mjs';
import { World } from './world.mjs';

const CYCLE_NS = 8;
const CAUSES = {
  // of the wire: what the chip's registers say of it
  0: { power: 1 << 8, reason: 0, kept: false, dark: true },
  1: { power: 1 << 16, reason: 0, kept: false, dark: false },
  2: { power: 1 << 8, reason: 0, kept: false, dark: true },
  3: { power: 1 << 8, reason: 1, kept: true, dark: false },
};
const INPUT_PINS = [15, 14]; // part present, guard closed
const FAULT_PIN = 19;
const FLASH_AT = 0x10000000;
const STACK_BOTTOM = 0x20000000;
const clock = new RP2040().clock;
const [, , image, linkName, facts] = process.argv;
const bought = keep(load(fs.readFileSync(image)), Buffer.from(facts, 'hex')); // what its flash then holds
const overUsb = linkName === 'usb';
let flash, world, life, lines, resets;
let chip;
let link; // the chip's UART, or a host at its USB

// A board on a bench where nothing has turned yet gets power for the first time.
function begin() {
  clock.nanosCounter = 0;
  flash = new FlashChip(clock, bought.slice());
  world = new World();
  const { count } = world.facts(0);
  life = { power: 1 << 8, reason: 0, scratch: new Uint32Array(8), noise: 1, torn: 1, count };
  lines = { closed: 0, complains: false };
  resets = 0;
  start();
}

function showLines() {
  INPUT_PINS.forEach((pin, n) => chip.gpio[pin].setInputValue(!(lines.closed & (1 << n))));
  chip.gpio[FAULT_PIN].setInputValue(!lines.complains);
}

function random() {
  life.torn = (Math.imul(life.torn, 1664525) + 1013904223) >>> 0;
  return life.torn >>> 24;
}

function start() {
  clock.nextAlarm = null; // the timers of the chip before
  world.open(clock.nanos);
  clock.tick(Math.max(flash.busyUntil - clock.nanos, 0)); // the boot ROM waits until it can read
  chip = new Chip(clock, flash, world, life);
  link = overUsb ? new UsbHost(chip) : chip;
  showLines();
}

function restart(cause) {
  Object.assign(life, { power: cause.power, reason: cause.reason });
  if (!cause.kept) life.scratch = new Uint32Array(8);
  if (cause.dark) flash.losePower(random);
  resets++;
  start();
}

function run(until) {
  while (clock.nanos < until) {
    if (chip.core.waiting) {
      const next = clock.nextAlarm ? clock.nanosToNextAlarm : Infinity;
      clock.tick(Math.min(next, until - clock.nanos));
    } else {
      clock.tick(chip.core.executeInstruction() * CYCLE_NS);
    }
    if (chip.resetWanted) restart({ power: life.power, reason: life.reason, kept: true });
  }
}

function set(text) {
  const [name, value] = [text.slice(0, text.indexOf('=')), Number(text.slice(text.indexOf('=') + 1))];
  switch (name) {
    case 'reset':
      return restart(CAUSES[value]);
    case 'inputs':
      lines.closed = value;
      return showLines();
    case 'complain':
      lines.complains = value !== 0;
      return showLines();
    case 'encoder':
      chip.forced = value;
      return chip.showCount(life.count);
    case 'stall': // the main loop hangs, and interrupts go on
      return hang(false);
    case 'hang':
      return hang(true);
    case 'wander': // the program begins again without a reset
      chip.core.PC = chip.readUint32(FLASH_AT + 0x104) & ~1;
      chip.core.waiting = false;
      return undefined;
    case 'fault': // a crash: the processor reads where nothing is
      chip.core.waiting = false;
      return chip.core.exceptionEntry(3);
    case 'deep': // the stack has come so near to its bottom, in bytes
      return chip.writeUint32(STACK_BOTTOM + value, 0);
    case 'spoil': // a byte of flash, from its beginning
      flash.bytes[value] ^= 0xff;
      return undefined;
    default:
      return world.set(text, clock.nanos);
  }
}

const LOOP = 0xe7fe; // branches to itself
function hang(off) {
  const at = 0x20041e00; // RAM that nothing uses
  while (chip.core.IPSR !== 0) run(clock.nanos + CYCLE_NS); // not an interrupt
  chip.writeUint16(at, LOOP);
  chip.core.PC = at;
  chip.core.waiting = false;
  if (off) chip.core.PM = true;
}

function take(size) {
  const buffer = Buffer.alloc(size);
  let have = 0;
  while (have < size) {
    const count = fs.readSync(0, buffer, have, size - have, null);
    if (count === 0) process.exit(0);
    have += count;
  }
  return buffer;
}

function answer(bytes) {
  const head = Buffer.alloc(12);
  head.writeDoubleLE(clock.nanos * 1e-9, 0);
  head.writeUInt32LE(bytes.length, 8);
  const all = Buffer.concat([head, bytes]);
  let done = 0;
  while (done < all.length) done += fs.writeSync(1, all, done);
}

function serve() {
  const kind = take(1).toString();
  if (kind === 'R') {
    const head = take(12);
    link.hear(take(head.readUInt32LE(8)));
    run(Math.ceil(head.readDoubleLE(0) * 1e9));
    answer(link.take(clock.nanos));
  } else if (kind === 'S') {
    set(take(take(4).readUInt32LE()).toString());
    answer(Buffer.alloc(0));
  } else if (kind === 'G') {
    const { a, b, enable } = world.shown;
    const { closed, ...rest } = world.facts(clock.nanos);
    const facts = { ...rest, a, b, enable: enable ? 1 : 0, enabled: closed, resets };
    answer(Buffer.from(JSON.stringify(facts)));
  } else if (kind === 'U') {
    const { device, configuration, texts } = link.identity;
    answer(Buffer.from(JSON.stringify({ device: [...device], configuration: [...configuration], texts })));
  } else if (kind === 'N') {
    begin();
    answer(Buffer.alloc(0));
  } else if (kind === 'M') {
    answer(Buffer.from(JSON.stringify(chip.times)));
    chip.times = { sample: 0, opened: 0, openings: 0 };
  } else {
    process.exit(2);
  }
}

begin();
for (;;) serve();
