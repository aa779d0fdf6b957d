"""emu://uno?motor=…: the real firmware on an emulated board, as a port. Development installs only.

The emulator is a process of its own (libsimavr is GPL-3), built on first use beside the firmware.
Time moves only while somebody waits in ``read``, as with sim://; ``speed=realtime`` follows the
wall clock. See docs/emulated-rig.md.
"""

from __future__ import annotations

import contextlib
import json
import struct
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit

import numpy as np
from motorid.sim._plant import ffi

from motorid.errors import LinkError, UsageError
from motorid.sim.bench import plant_params
from motorid.sim.chain import draw_chain
from motorid.sim.options import CLOCK_HZ, Options, parse_url
from motorid.wire.enums import Bridge

ROOM = Path(__file__).parent
if str(ROOM) not in sys.path:
    sys.path.append(str(ROOM))  # this file is no module of a package

from emu_build import PICO, build, missing, missing_for_pico  # noqa: E402
from emu_facts import facts, slot  # noqa: E402

__all__ = ["Emulator", "missing", "missing_for_pico", "open_emu"]
CHIPS = {"uno": "atmega328p", "mega": "atmega2560"}
BOARDS = (*CHIPS, PICO)
COMPILERS = ("gcc", "clang")
LINKS = ("uart", "usb")
# options of emu:// alone
OWN = ("shunt", "divider", "defines", "compiler", "boot", "driver", "link")
SHUNTS_OHM = (0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005)
DIVIDERS = (4, 8, 16)
SHUNT_GAIN = 20.0
HEADROOM = 1.25  # of the converter's range over stall current and supply
COUNTS_PER_TURN = 256  # what a small board's encoder input can follow
CURRENT_GAIN, VOLTAGE_GAIN = 0.004, 0.001  # standard uncertainties, as shield.h and the facts say
STRETCH_S, POLL_S = 2e-3, 1e-3
CYCLE_S = 1 / 16e6


@dataclass(frozen=True)
class Analog:
    """A board's converter and what is before it, as the firmware's shield.h or the facts say."""

    clock_hz: float
    codes: int
    reference_v: float
    lift_v: float  # of dividers at 0 V
    differential: bool  # the terminals' difference is one input
    filter_s: float
    current_filter_s: float
    offset_lsb: float  # standard, common to the inputs
    mismatch_lsb: float  # between inputs of one converter
    noise_lsb: float
    reference_noise: float  # relative, and how long it lasts
    reference_noise_s: float
    wide: tuple[float, float]  # codes that the four wide ones of an RP2040 take (E11): least, most


AVR = Analog(
    16e6,
    1024,
    4.096,
    4.096 / 16,
    False,
    58.75e-6,
    22e-6,
    4.5 / 3**0.5,
    0.7,
    0.5,
    0.0,
    1.0,
    (0.0, 0.0),
)
RP2040 = Analog(
    125e6, 4096, 3.0, 0.0, True, 12.5e-6, 4.7e-6, 2.0, 0.0, 1.5, 2.5e-4, 0.44e-3, (7.0, 11.0)
)


def analog(board: str) -> Analog:
    """That of a board."""
    return RP2040 if board == PICO else AVR


# Options of sim:// that make sense here; the rest belongs to the real firmware.
FORBIDDEN = {
    "aperture", "delay", "phase", "voltage_aperture", "bits", "pwm", "decay_modes", "current_range",
    "voltage_range", "gain_uncertainty", "voltage_gain_uncertainty", "offset_uncertainty",
    "edge_ceiling", "first_tick", "baud", "buffer", "max_steps", "fault",
}  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """What an emu:// URL asks for."""

    board: str
    options: Options
    shunt_ohm: float
    divider: int
    defines: str = ""  # further -D for the firmware
    compiler: str = "gcc"  # or clang, the second one
    boot: str = ""  # a bootloader's hex file, which runs first
    driver: str = "mosfet"  # of the bridge: a name of the wire's
    link: str = "uart"  # or usb, a Pico's


def parse(url: str) -> Setting:
    """The setting of an emu:// URL. Raises UsageError."""
    parts = urlsplit(url)
    board = parts.netloc
    if board not in BOARDS:
        raise UsageError(
            f"{url}: write emu://uno?motor=…, emu://mega?motor=… or emu://pico?motor=…"
        )
    pairs = parse_qsl(parts.query, keep_blank_values=True)
    own = {k: v for k, v in pairs if k in OWN}
    rest = [(k, v) for k, v in pairs if k not in own]
    if bad := sorted(FORBIDDEN & {k for k, _ in rest}):
        raise UsageError(f"{url}: {bad[0]} is the firmware's own here; see docs/emulated-rig.md")
    options = parse_url(f"sim://?{urlencode(rest)}")
    names = {k for k, _ in rest}
    if "counts_per_turn" not in names:
        options = replace(options, counts_per_turn=COUNTS_PER_TURN)
    if "noise" not in names:
        options = replace(options, noise=analog(board).noise_lsb)
    volts = analog(board).reference_v
    amps = HEADROOM * options.preset.stall_current_a
    fits = [r for r in SHUNTS_OHM if volts / 2 / SHUNT_GAIN / r >= amps]
    reach = [d for d in DIVIDERS if volts * 15 / 16 * d >= 1.05 * options.supply_v]
    try:
        shunt = float(own["shunt"]) if "shunt" in own else (fits or [SHUNTS_OHM[-1]])[0]
        divider = int(own["divider"]) if "divider" in own else (reach or [DIVIDERS[-1]])[0]
    except ValueError:
        raise UsageError(f"{url}: shunt is in ohm, divider a whole number") from None
    compiler = own.get("compiler", "gcc")
    if compiler not in COMPILERS:
        raise UsageError(f"{url}: the firmware's compiler is {' or '.join(COMPILERS)}")
    driver = own.get("driver", "mosfet")
    if driver.upper() not in Bridge.__members__:
        raise UsageError(f"{url}: driver is one of {', '.join(Bridge.__members__).lower()}")
    link = own.get("link", LINKS[0])
    if link not in LINKS or (link == "usb" and board != PICO):
        raise UsageError(f"{url}: link is uart, or with a pico usb")
    defines, boot = own.get("defines", ""), own.get("boot", "")
    return Setting(board, options, shunt, divider, defines, compiler, boot, driver, link)


def parameters(setting: Setting) -> dict[str, float]:
    """The rig's parameters: the simulator's plant, and errors of the shield drawn by the seed."""
    options, parts = setting.options, analog(setting.board)
    chain = draw_chain(options)
    plant: Any = plant_params(options, chain)
    names = [name for name, _ in ffi.typeof("plant_params").fields]
    values = {name: float(getattr(plant, name)) for name in names}
    rng = np.random.default_rng([options.seed, 4])
    drawn, common = rng.standard_normal(8), rng.standard_normal()
    for n, spread in enumerate((VOLTAGE_GAIN, CURRENT_GAIN, VOLTAGE_GAIN, VOLTAGE_GAIN)):
        given = options.gain_error if n == 1 else options.voltage_gain_error
        error = spread * drawn[n] if given is None else given
        shift = parts.offset_lsb * common + parts.mismatch_lsb * drawn[4 + n]
        values[f"gain[{n}]"] = float(1 + error)
        values[f"offset[{n}]"] = float(
            shift if options.offset_error is None else options.offset_error
        )
    for n, width in enumerate(rng.uniform(*parts.wide, 4)):
        values[f"wide[{n}]"] = float(width)
    values |= {
        "clock_hz": chain.clock_hz * parts.clock_hz / CLOCK_HZ,
        "reference": parts.reference_v,
        "codes": parts.codes,
        "differential": float(parts.differential),
        "shunt": setting.shunt_ohm * SHUNT_GAIN,
        "zero": parts.reference_v / 2,
        "driver": Bridge[setting.driver.upper()],
        "one_sided": 0,
        "divider": setting.divider,
        "lift": parts.lift_v,
        "filter": parts.filter_s,
        "current_filter": parts.current_filter_s,
        "noise": options.noise,
        "reference_noise": parts.reference_noise * options.noise / parts.noise_lsb,
        "reference_noise_s": parts.reference_noise_s,
        "counts_per_turn": options.counts_per_turn,
        "encoder_angle": chain.encoder_angle,
        "encoder_sign": 1,
        "seed": options.seed,
    }
    return values


def command(setting: Setting) -> list[str]:
    """What starts the emulated board, built if need be."""
    emulator, image = build(setting.board, setting.compiler, f"{_parts(setting)} {setting.defines}")
    pairs = [f"{name}={float(value)!r}" for name, value in parameters(setting).items()]
    if setting.board == PICO:
        chip = ["node", str(ROOM / "pico" / "pico.mjs"), str(image), setting.link, _kept(setting)]
        return [str(emulator), *pairs, "--", *chip]
    return [str(emulator), str(image), CHIPS[setting.board], setting.boot, *pairs]


def _is_bare(setting: Setting) -> bool:
    return setting.options.front_end == "none"


def _parts(setting: Setting) -> str:
    """Those that an Uno's or Mega's firmware is compiled for. A Pico's has facts of none."""
    if setting.board == PICO:
        return ""
    holds = "-DSHIELD_HOLDS=false" if _is_bare(setting) else ""
    return f"-DSHUNT_OHM={setting.shunt_ohm!r}f -DDIVIDER={setting.divider}.0f {holds}".strip()


def _kept(setting: Setting) -> str:
    """A Pico's facts in its flash, in hex; none: it is as it comes."""
    if _is_bare(setting):
        return ""
    bridge = Bridge[setting.driver.upper()]
    return slot(facts(setting.shunt_ohm * SHUNT_GAIN, setting.divider, bridge)).hex()


# ---------------------------------------------------------------- the process


class Emulator:
    """One emulated board. Time is the board's, in seconds since power-on."""

    def __init__(self, url: str) -> None:
        self.setting = parse(url)
        self._process = subprocess.Popen(
            command(self.setting),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        self.now = 0.0
        self._heard = b""
        self._said = b""

    def _ask(self, request: bytes) -> bytes:
        pipe_in, pipe_out = self._process.stdin, self._process.stdout
        assert pipe_in
        assert pipe_out
        try:
            pipe_in.write(request)
            pipe_in.flush()
        except OSError:
            raise LinkError("emu://: the emulator died") from None
        head = pipe_out.read(12)
        if len(head) < 12:
            raise LinkError("emu://: the emulator died")
        self.now, length = struct.unpack("<dI", head)
        return pipe_out.read(length)

    def hear(self, data: bytes) -> None:
        """Bytes to the board, from now on at the link's rate."""
        self._heard += data

    def advance_to(self, until_s: float) -> None:
        """Let the board run up to that time."""
        heard, self._heard = self._heard, b""
        self._said += self._ask(b"R" + struct.pack("<dI", until_s, len(heard)) + heard)

    def take(self, size: int) -> bytes:
        """At most ``size`` of the bytes that the board has said."""
        data, self._said = self._said[:size], self._said[size:]
        return data

    def check(self) -> None:
        """Raises LinkError when the emulator is gone."""
        if self._process.poll() is not None:
            raise LinkError("emu://: the emulator died")

    def set(self, name: str, value: float) -> None:
        """Change the rig now: supply, locked, encoder, chatter, complain, inputs, gain[1] …

        Or the chip: efuse, a byte of eeprom[64] …

        Or what goes wrong in the processor: reset (to what MCUSR says), power (a seed of what
        memory then holds), r2, hang and stall (with interrupts off and on), unstall, wander.
        """
        text = f"{name}={value!r}".encode()
        self._ask(b"S" + struct.pack("<I", len(text)) + text)

    def facts(self) -> dict[str, Any]:
        """Pins, motor and processor as they are now."""
        found: dict[str, Any] = json.loads(self._ask(b"G"))
        return found

    def usb(self) -> dict[str, Any]:
        """What the host at a Pico's USB was told: both descriptors, and maker, name and number."""
        found: dict[str, Any] = json.loads(self._ask(b"U"))
        return found

    def times(self) -> dict[str, Any]:
        """What was timed since this was last asked, in cycles: meter.h has the names."""
        found: dict[str, Any] = json.loads(self._ask(b"M"))
        return found

    def renew(self) -> None:
        """A new board on a new bench, as the URL has them. A Pico's emulator alone does that."""
        self._ask(b"N")
        self._heard = self._said = b""

    def close(self) -> None:
        """End the process; may be called twice."""
        if self._process.poll() is None:
            self._process.kill()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe and not pipe.closed:
                with contextlib.suppress(OSError):  # a dead process leaves a broken pipe
                    pipe.close()
        self._process.wait()


class EmuPort:
    """A port whose time is the emulated board's: it moves while the client waits in ``read``."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.board = Emulator(name)

    def read(self, size: int, timeout_s: float) -> bytes:
        """See motorid.acquire.port.Port."""
        deadline = self.now() + timeout_s
        while not (data := self.board.take(size)):
            if deadline - self.now() < CYCLE_S:
                return b""
            self._pass_time(deadline)
        return data

    def _pass_time(self, deadline: float) -> None:
        self.board.advance_to(min(deadline, self.board.now + STRETCH_S))

    def write(self, data: bytes) -> None:
        """See motorid.acquire.port.Port."""
        self.board.check()
        self.board.hear(data)

    def now(self) -> float:
        """Seconds on the board's clock."""
        return self.board.now

    def close(self) -> None:
        """See motorid.acquire.port.Port."""
        self.board.close()


class RealTimeEmuPort(EmuPort):
    """The same at the pace of the wall clock."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._began = time.monotonic()

    def _pass_time(self, deadline: float) -> None:
        self.board.advance_to(time.monotonic() - self._began)
        if not self.board._said:
            time.sleep(max(min(POLL_S, deadline - self.now()), 0.0))

    def now(self) -> float:
        """Seconds of the wall clock since the port was opened."""
        return time.monotonic() - self._began


def open_emu(url: str) -> EmuPort:
    """The emulated board of an emu:// URL. Raises UsageError, or RigError if it will not build."""
    paced = "speed=realtime" in urlsplit(url).query.split("&")
    return (RealTimeEmuPort if paced else EmuPort)(url)
