// An RP2040 by rp2040js, with what it lacks or does otherwise than silicon mended from here:
// docs/firmware.md has the list. The firmware's image is the one that a Pico is flashed with.
import { BasePeripheral, ConsoleLogger, LogLevel, RP2040 } from 'rp2040js';
import { decodeBlock } from 'uf2';
import { FlashInterface, FlashSelect } from './flash.mjs';
import { LOW } from './world.mjs';

export const BYTE_NS = 10_000; // of the UART: ten bits of 1 us
const FLASH_AT = 0x10000000;
const BOOT_AT = 0x20041f00; // where the boot ROM runs the second stage
const BOOT_BYTES = 256;
const ALL_IN_RESET = 0x1ffffff;
const CONVERSION_NS = 2_000;
const WINDOW_NS = 50_000; // 25 conversions
const SAMPLE_EXCEPTION = 16 + 11; // DMA_IRQ_0
const PIO_FSTAT = 0x004;
const PIO_RXF0 = 0x020;
const ROUND = 12; // instructions, longer than the longest round of the encoder's program
const UART_QUEUE = 32;
const TX_FULL = 1 << 5;
const FUNCTION_PWM = 4;
const OVERRIDE_LOW = 2;
const ENABLE = 18;
const LEVELS = [16, 17];
const INPUTS = [...LEVELS, ENABLE];
const PERIOD = 6250;
const A_INVERTED = 1 << 2; // of a slice's CSR; the next bit is B's
const ENCODER = [20, 21];
const RESETS = 0x4000c;
const WATCHDOG = 0x40058;
const RING_OSCILLATOR = 0x40060;
const CHIP_RESET = 0x40064;
const FLASH_INTERFACE = 0x18000;
const FLASH_PINS = 0x40018;

// UF2 blocks as flash; the chip's boot ROM asks for the CRC.
export function load(file) {
  const flash = new Uint8Array(1 << 21).fill(0xff);
  for (let at = 0; at < file.length; at += 512) {
    const block = decodeBlock(file.subarray(at, at + 512));
    flash.set(block.payload, block.flashAddress - FLASH_AT);
  }
  return flash;
}

function crc(bytes) {
  let sum = 0xffffffff;
  for (const byte of bytes) {
    sum ^= byte << 24;
    for (let n = 0; n < 8; n++) sum = sum & 0x80000000 ? (sum << 1) ^ 0x04c11db7 : sum << 1;
  }
  return sum >>> 0;
}

class Word extends BasePeripheral {
  // One register that is read, the same at each of its addresses.
  constructor(chip, name, read) {
    super(chip, name);
    this.readUint32 = read;
    this.writeUint32 = () => {};
  }
}

export class Chip extends RP2040 {
  // `life`: what outlasts a reset: why it came, scratch registers, noise. `flash`: a FlashChip.
  constructor(clock, flash, world, life) {
    super(clock);
    this.logger = new ConsoleLogger(LogLevel.Error, false);
    this.world = world;
    this.life = life;
    this.resetWanted = false;
    this.mendPower();
    this.mendEncoder();
    this.mendPwm();
    this.mendConverter();
    this.mendUart();
    this.meterSamples();
    this.boot(flash);
  }

  // Times since the end of the latest window: of the sample interrupt's return, and of the bridge's opening.
  meterSamples() {
    const { core } = this;
    const leave = core.exceptionReturn.bind(core);
    this.times = { sample: 0, opened: 0, openings: 0 };
    core.exceptionReturn = (how) => {
      if (core.IPSR === SAMPLE_EXCEPTION) this.times.sample = Math.max(this.times.sample, this.sinceWindow());
      leave(how);
    };
  }

  sinceWindow() {
    return ((this.clock.nanos - this.started) % WINDOW_NS) * 1e-9;
  }

  // There is no boot ROM: it would check the second stage, copy it to RAM and call it. What is written to the
  // flash chip is to be read at addresses.
  boot(flash) {
    this.peripherals[FLASH_INTERFACE] = new FlashInterface(this, flash);
    this.peripherals[FLASH_PINS] = new FlashSelect(this, flash);
    this.flash.set(flash.bytes);
    flash.bytes = this.flash.subarray(0, flash.bytes.length);
    const stage = flash.bytes.subarray(0, BOOT_BYTES);
    const sum = new DataView(stage.buffer, stage.byteOffset).getUint32(BOOT_BYTES - 4, true);
    if (crc(stage.subarray(0, BOOT_BYTES - 4)) !== sum) throw new Error('the second boot stage has a wrong CRC');
    this.sram.set(stage, BOOT_AT - 0x20000000);
    this.core.SP = BOOT_AT;
    this.core.PC = BOOT_AT;
  }

  // Peripherals begin in reset; power and noise have no registers; a watchdog only calls back, for ever.
  mendPower() {
    const { peripherals, life } = this;
    peripherals[RESETS].reset = ALL_IN_RESET;
    peripherals[CHIP_RESET] = new Word(this, 'CHIP_RESET', () => life.power);
    peripherals[RING_OSCILLATOR] = new Word(this, 'ROSC', () => {
      life.noise = (Math.imul(life.noise, 1664525) + 1013904223) >>> 0;
      return life.noise >>> 31;
    });
    const watchdog = peripherals[WATCHDOG];
    watchdog.reason = life.reason;
    watchdog.scratchData = life.scratch;
    watchdog.onWatchdogTrigger = () => {
      watchdog.alarm.enable = false;
      life.reason = watchdog.reason;
      this.resetWanted = true;
    };
  }

  // Pins are not toggled at each edge: the rig is told the compares as a period begins.
  mendPwm() {
    const [levels, enable] = this.pwm.channels;
    for (const slice of this.pwm.channels) slice.alarmA.enable = slice.alarmB.enable = false;
    for (const slice of [levels, enable]) {
      slice.wrap = () => {
        this.pwm.intRaw |= 1 << slice.index;
        slice.updateDoubleBuffered();
        if (slice === levels) this.beginPeriod(levels, enable);
      };
    }
    for (const pin of INPUTS) this.gpio[pin].checkForUpdates = () => this.noteOpening();
  }

  // The bridge is open once all inputs of its driver are let go or forced low.
  noteOpening() {
    if (INPUTS.some((pin) => this.isFree(pin)) || this.isOff) return;
    this.isOff = true;
    if (!this.world.active) return; // nothing was high
    this.times.opened = Math.max(this.times.opened, this.sinceWindow());
    this.times.openings++;
    this.world.open(this.clock.nanos);
    this.nextEdge();
  }

  isFree(pin) {
    const { functionSelect, outputOverride, outputDisable } = this.gpio[pin];
    return functionSelect === FUNCTION_PWM && outputOverride !== OVERRIDE_LOW && !outputDisable;
  }

  beginPeriod(levels, enable) {
    const [a, b] = [levels.cc & 0xffff, levels.cc >>> 16].map((ticks, n) => this.wave(n, ticks, levels.csr));
    const enabled = this.isFree(ENABLE) && (enable.cc & 0xffff) > 0;
    this.isOff = INPUTS.every((pin) => !this.isFree(pin));
    this.world.period(this.clock.nanos, { a, b, enable: enabled }, !!(this.adc.cs & (1 << 3)));
    this.nextEdge();
  }

  // Of a level: the ticks of the period between which it is high.
  wave(n, ticks, csr) {
    const wide = Math.min(ticks, PERIOD);
    const [from, to] = csr & (A_INVERTED << n) ? [wide, PERIOD] : [0, wide];
    return this.isFree(LEVELS[n]) && from < to ? [from, to] : LOW;
  }

  // Its round-robin never leaves the first input, and it converts no analogue world.
  mendConverter() {
    const { adc, world, clock } = this;
    Object.defineProperty(adc, 'activeChannel', {
      get: () => (adc.cs >> 12) & 7,
      set: (input) => {
        adc.cs = (adc.cs & ~(7 << 12)) | ((input & 7) << 12);
      },
    });
    adc.onADCRead = (input) => {
      this.started ??= clock.nanos;
      adc.currentChannel = input;
      adc.channelValues[input] = world.code(clock.nanos, input);
      adc.sampleAlarm.schedule(CONVERSION_NS);
    };
  }

  // The PIO runs outside simulated time: it is stepped when its pins change and when it is read.
  mendEncoder() {
    const pio = this.pio[0];
    const read = pio.readUint32.bind(pio);
    pio.run = () => {};
    pio.readUint32 = (offset) => {
      if (offset === PIO_FSTAT || offset === PIO_RXF0) this.stepEncoder();
      return read(offset);
    };
    this.edgeAlarm = this.clock.createAlarm(() => this.nextEdge());
    this.forced = -1; // the encoder's lines, where a test holds them
    this.showCount(this.life.count);
  }

  stepEncoder() {
    const machine = this.pio[0].machines[0];
    if (machine.enabled) for (let n = 0; n < ROUND; n++) machine.step();
  }

  // A leads: 00 10 11 01.
  showCount(count) {
    const place = count & 3;
    const lines = this.forced >= 0 ? this.forced : (place === 1 || place === 2 ? 1 : 0) | (place >= 2 ? 2 : 0);
    ENCODER.forEach((pin, n) => this.gpio[pin].setInputValue(!!(lines & (1 << n))));
    this.life.count = count;
    this.stepEncoder();
    this.stepEncoder();
  }

  nextEdge() {
    this.edgeAlarm.cancel();
    const now = this.clock.nanos;
    const { edges } = this.world;
    while (edges.length > 0 && edges[0][0] <= now) this.showCount(edges.shift()[1]);
    if (edges.length > 0) this.edgeAlarm.schedule(edges[0][0] - now);
  }

  // It sends at once: the queue and its speed are made up for here. What it receives is paced, too.
  mendUart() {
    const uart = this.uart[0];
    const received = Object.getOwnPropertyDescriptor(Object.getPrototypeOf(uart), 'flags').get;
    this.said = []; // when the byte is over, and the byte
    this.heard = [];
    this.sentUntil = 0;
    Object.defineProperty(uart, 'flags', {
      get: () => {
        const waiting = (this.sentUntil - this.clock.nanos) / BYTE_NS - 1;
        return received.call(uart) | (waiting > UART_QUEUE - 1 ? TX_FULL : 0);
      },
    });
    uart.onByte = (byte) => {
      this.sentUntil = Math.max(this.sentUntil, this.clock.nanos) + BYTE_NS;
      this.said.push([this.sentUntil, byte]);
    };
    this.byteAlarm = this.clock.createAlarm(() => {
      if (!uart.rxFIFO.full) uart.feedByte(this.heard.shift());
      else this.heard.shift(); // an overrun
      if (this.heard.length > 0) this.byteAlarm.schedule(BYTE_NS);
    });
  }

  hear(bytes) {
    const idle = this.heard.length === 0;
    for (const byte of bytes) this.heard.push(byte);
    if (idle && bytes.length > 0) this.byteAlarm.schedule(BYTE_NS);
  }

  take(now) {
    let n = 0;
    while (n < this.said.length && this.said[n][0] <= now) n++;
    return Buffer.from(this.said.splice(0, n).map(([, byte]) => byte));
  }
}
