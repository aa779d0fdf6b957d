"""Good small captures, and absurd damage to them, each named by a line of text.

A line is ``BASE | damage args | damage args``: what is found once can be kept, whatever becomes of
the drawing.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, VOLTAGE, Capture, Channel, Phase, Wiring
from motorid.capture.table import read_table
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.frozen.cases import LOGS, MAPS, unpacked

LOG_ROWS = 200
BOARD_ROWS = {"emulated-uno-0": 900, "thermal-figures-0": 700}
LOG_COLUMNS = {
    "steps": "viw", "position": "vip", "random-stamps": "viw", "motionless": "vi",
    "motionless-random-stamps": "vi", "locked-rotor": "viw", "mechanical": "iw",
    "no-current": "vw", "coast-down": "w", "tachometer": "v",
}  # fmt: skip
BASES = ("exact", "exact-motionless", *BOARD_ROWS, *LOG_COLUMNS)
NUMBERS = (
    "0", "-1", "1e-300", "1e-30", "1e-12", "1e-6", "1e3", "1e9", "1e12", "1e30", "1e150", "1e300",
    "-1e300", "1.7e308", "5e-324", "nan", "inf",
)  # fmt: skip
WIRED = tuple(f.name for f in fields(Wiring))
FACTS = (
    "scale", "offset", "aperture_s", "delay_s", "pwm_phase", "resolution", "noise",
    "gain_uncertainty", "offset_uncertainty", "delay_uncertainty_s", "filter_s",
    "filter_damping", "nonlinearity", "full_scale",
)  # fmt: skip


@cache
def base(name: str) -> Capture:
    """A good capture of that name."""
    if name.startswith("exact"):
        plan = Plan(count=600, period_s=3e-4)
        capture = noisy(clean_capture(FAULHABER, plan), 1, 5e-3, 1e-3)
        if name == "exact":
            return capture
        return replace(capture, channels=_without(capture.channels, POSITION))
    if name in BOARD_ROWS:
        return head(unpacked(name), BOARD_ROWS[name])
    maps = ("time=t:s", *(MAPS[c] for c in LOG_COLUMNS[name]))
    return head(read_table(LOGS / f"{name}.csv", maps), LOG_ROWS)


def head(capture: Capture, count: int) -> Capture:
    """Its first samples."""
    return taken(capture, np.arange(min(count, len(capture))))


def taken(capture: Capture, rows: NDArray[np.intp]) -> Capture:
    """Some of its samples, in that order."""
    channels = {n: replace(c, raw=np.asarray(c.raw)[rows]) for n, c in capture.channels.items()}
    return replace(capture, ticks=capture.ticks[rows], channels=channels, gaps=())


def _without(channels: Mapping[str, Channel], name: str) -> dict[str, Channel]:
    return {n: c for n, c in channels.items() if n != name}


def _readings(capture: Capture, name: str, change: Callable[[Any], Any]) -> Capture:
    """With the raw readings of one channel changed, in floating point."""
    channel = capture.get(name)
    if channel is None:
        return capture
    raw = change(np.array(channel.raw, dtype=np.float64))
    return replace(capture, channels={**capture.channels, name: replace(channel, raw=raw)})


def _put(rows: slice, value: float) -> Callable[[Any], Any]:
    def change(raw: Any) -> Any:
        raw[rows] = value
        return raw

    return change


def _rows(capture: Capture, share: str, length: str) -> slice:
    first = int(float(share) * len(capture))
    return slice(first, first + max(1, int(float(length) * len(capture))))


def constant(capture: Capture, name: str, value: str) -> Capture:
    return _readings(capture, name, _put(slice(None), float(value)))


def run(capture: Capture, name: str, value: str, share: str, length: str) -> Capture:
    return _readings(capture, name, _put(_rows(capture, share, length), float(value)))


def sprinkle(capture: Capture, name: str, value: str, every: str) -> Capture:
    return _readings(capture, name, _put(slice(None, None, int(every)), float(value)))


def grow(capture: Capture, name: str, factor: str) -> Capture:
    with np.errstate(all="ignore"):
        return _readings(capture, name, lambda raw: raw * float(factor))


def alias(capture: Capture, name: str, size: str) -> Capture:
    """Alternating between ± the size: a PWM sampled in its own rhythm."""
    signs = (-1.0) ** np.arange(len(capture))
    return _readings(capture, name, lambda raw: float(size) * signs)


def chop(capture: Capture, name: str) -> Capture:
    """Every other reading is 0."""
    return _readings(capture, name, _put(slice(None, None, 2), 0.0))


def swap(capture: Capture, one: str, other: str) -> Capture:
    a, b = capture.get(one), capture.get(other)
    if a is None or b is None:
        return capture
    swapped = {one: replace(a, raw=b.raw), other: replace(b, raw=a.raw)}
    return replace(capture, channels={**capture.channels, **swapped})


def saturate(capture: Capture, name: str) -> Capture:
    channel = capture.get(name)
    if channel is None:
        return capture
    full = replace(channel, raw_min=-1e-9, raw_max=1e-9)
    return replace(capture, channels={**capture.channels, name: full})


def drop(capture: Capture, name: str) -> Capture:
    return replace(capture, channels=_without(capture.channels, name))


def unsign(capture: Capture, name: str) -> Capture:
    channel = capture.get(name)
    if channel is None:
        return capture
    changed = replace(channel, unsigned=True)
    return replace(capture, channels={**capture.channels, name: changed})


def sense(capture: Capture, where: str) -> Capture:
    channel = capture.get(VOLTAGE)
    if channel is None:
        return capture
    changed: Any = replace(channel, sense=where)  # type: ignore[arg-type]
    return replace(capture, channels={**capture.channels, VOLTAGE: changed})


def fact(capture: Capture, name: str, field: str, value: str) -> Capture:
    channel = capture.get(name)
    if channel is None:
        return capture
    changed: Any = replace(channel, **{field: float(value)})
    return replace(capture, channels={**capture.channels, name: changed})


def wire(capture: Capture, field: str, value: str) -> Capture:
    changes: dict[str, Any] = {field: float(value)}
    return replace(capture, wiring=replace(capture.wiring, **changes))


def clock(capture: Capture, hertz: str) -> Capture:
    return replace(capture, clock_hz=float(hertz))


def doubt(capture: Capture, relative: str) -> Capture:
    return replace(capture, clock_uncertainty=float(relative))


def warm(capture: Capture, celsius: str) -> Capture:
    return replace(capture, ambient_c=float(celsius), ambient_uncertainty_c=float(celsius))


def ticks(capture: Capture, how: str) -> Capture:
    old, rng = capture.ticks, np.random.default_rng(1)
    ways: dict[str, Callable[[], Any]] = {
        "still": lambda: np.zeros_like(old),
        "reversed": lambda: old[::-1].copy(),
        "repeated": lambda: np.repeat(old[::2], 2)[: len(old)],
        "shuffled": lambda: rng.permutation(old),
        "far": lambda: np.append(old[:-1], np.int64(2**62)),
        "apart": lambda: np.arange(len(old), dtype=np.int64) * (2**62 // len(old)),
        "grown": lambda: np.cumsum(np.minimum(2 ** (np.arange(len(old)) // 4), 2**50)),
        "pairs": lambda: np.repeat(old[::2], 2)[: len(old)] + np.arange(len(old)) % 2,
        "jitter": lambda: np.cumsum(rng.integers(1, 2000, len(old))),
    }
    return replace(capture, ticks=ways[how]().astype(np.int64))


def phases(capture: Capture, how: str) -> Capture:
    old = capture.phases
    last = int(capture.ticks[-1]) if len(capture) else 0
    ways: dict[str, Callable[[], Any]] = {
        "none": lambda: (),
        "reversed": lambda: old[::-1],
        "beyond": lambda: tuple(Phase(p.index + 1000, p.tick) for p in old),
        "negative": lambda: tuple(Phase(p.index - 3, p.tick) for p in old),
        "late": lambda: tuple(Phase(p.index, p.tick + last) for p in old),
        "huge": lambda: tuple(Phase(p.index, 2**62) for p in old),
        "early": lambda: tuple(Phase(p.index, -(2**62)) for p in old),
        "same": lambda: tuple(Phase(p.index, old[0].tick) for p in old),
        "single": lambda: tuple(Phase(p.index, last - k) for k, p in enumerate(old)),
        "each": lambda: tuple(Phase(k % 3, int(t)) for k, t in enumerate(capture.ticks)),
    }
    return replace(capture, phases=ways[how]())


def unprogrammed(capture: Capture) -> Capture:
    return replace(capture, program=None, phases=())


def cut(capture: Capture, count: str) -> Capture:
    return head(capture, int(count))


def every(capture: Capture, step: str) -> Capture:
    return taken(capture, np.arange(0, len(capture), int(step)))


def static(capture: Capture) -> Capture:
    return replace(capture, provenance={**capture.provenance, "static": True})


DAMAGES: Mapping[str, Callable[..., Capture]] = {
    f.__name__: f
    for f in (
        constant, run, sprinkle, grow, alias, chop, swap, saturate, drop, unsign, sense, fact,
        wire, clock, doubt, warm, ticks, phases, unprogrammed, cut, every, static,
    )
}  # fmt: skip


def damaged(line: str) -> Capture:
    """The capture that a line describes. Raises MotoridError where none can be made of it."""
    name, *damages = (part.strip() for part in line.split("|"))
    capture = base(name)
    for damage in damages:
        word, *arguments = damage.split()
        capture = DAMAGES[word](capture, *arguments)
    return capture


def drawn(rng: random.Random) -> str:
    """A line: one damage mostly, at times three."""
    name = rng.choice(BASES)
    names = list(base(name).channels)
    return " | ".join([name, *(_damage(rng, names) for _ in range(rng.choice((1, 1, 1, 2, 2, 3))))])


def _damage(rng: random.Random, channels: list[str]) -> str:
    def of(*choices: str) -> str:
        return rng.choice(choices)

    channel, number = rng.choice(channels), rng.choice(NUMBERS)
    share, length = of("0", "0.1", "0.5", "0.95"), of("0.001", "0.05", "0.3", "1")
    size = of("1e-3", "1", "6", "24", "1e3", "1e9")
    return of(
        f"constant {channel} {number}",
        f"run {channel} {number} {share} {length}",
        f"run {channel} nan {share} {length}",
        f"sprinkle {channel} {number} {of('2', '7', '50')}",
        f"grow {channel} {number}",
        f"alias {channel} {size}",
        f"alias {channel} {size}",
        f"chop {channel}",
        f"swap {channel} {rng.choice(channels)}",
        f"saturate {channel}",
        f"drop {channel}",
        f"unsign {channel}",
        f"sense {of('terminals', 'bridge', 'supply', 'command')}",
        f"fact {channel} {rng.choice(FACTS)} {number}",
        f"fact {channel} {rng.choice(FACTS)} {number}",
        f"wire {rng.choice(WIRED)} {number}",
        f"wire {rng.choice(WIRED)} {number}",
        f"clock {number}",
        f"doubt {number}",
        f"warm {number}",
        f"ticks {of('still', 'reversed', 'repeated', 'shuffled', 'far', 'apart', 'grown')}",
        f"ticks {of('pairs', 'jitter')}",
        f"phases {of('none', 'reversed', 'beyond', 'negative', 'late', 'huge', 'early')}",
        f"phases {of('same', 'single', 'each')}",
        "unprogrammed",
        f"cut {of('0', '1', '2', '15', '16', '17', '40')}",
        f"every {of('2', '10', '30')}",
        "static",
    )
