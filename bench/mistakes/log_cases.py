"""Mistakes in logs: what was done, and the words that name it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.mistakes.chain import late, low_pass, mean, rounded
from bench.mistakes.logs import Chain, Floats, Log, Rng, Station, Table, one_way, steps
from bench.mistakes.plant import Drive, Trace

PWM_LOCKED_AT = 0.25  # of a PWM period, counted from the rising edge


@dataclass(frozen=True)
class Mistake:
    """One mistake: what somebody did, the log it gives, patterns of which one must be said.

    ``traceless``: codes of what the report must list as not excluded, where data cannot show it.
    """

    name: str
    causes: tuple[str, ...]
    log: Log
    traceless: tuple[str, ...] = ()


def lagging(samples: float) -> Chain:
    """So many samples late."""
    return lambda x, s: late(x, s.period_s / 20, samples * s.period_s)


def filtered(samples: float, order: int = 1) -> Chain:
    """Through low-passes of so many samples each."""
    return lambda x, s: low_pass(x, s.period_s / 20, samples * s.period_s, order)


def averaged(samples: float, where: str = "before") -> Chain:
    """Means over so many samples."""
    return lambda x, s: mean(x, s.period_s / 20, samples * s.period_s, where)


def offset(share: float) -> Chain:
    """A current's zero that is off by a share of the stall current."""
    return lambda x, s: x + share * s.motor.stall_a


def times(factor: float) -> Chain:
    """A gain."""
    return lambda x, s: factor * x


def clipped(share: float) -> Chain:
    """An amplifier that ends at a share of the stall current."""
    return lambda x, s: np.clip(x, -share * s.motor.stall_a, share * s.motor.stall_a)


def coasting(station: Station) -> Drive:
    """The usual levels, with the bridge open at the third and at the last."""
    usual, level_s = steps(station), station.level_s
    return lambda t, i, w: None if int(t / level_s + 1e-9) in (3, 6) else usual(t, i, w)


def unseen(true: Trace, station: Station) -> Mapping[str, Floats]:
    """A command of 0 V while the bridge is open."""
    return {"v": np.where(true.opened, 0.0, true.volts)}


def sagging(station: Station) -> Drive:
    """A supply of 15 % of R behind the bridge's full duty."""
    usual, ohm = steps(station), 0.15 * station.motor.R
    return lambda t, i, w: (usual(t, i, w) or 0.0) - ohm * i


def unloaded(true: Trace, station: Station) -> Mapping[str, Floats]:
    """The volts that the supply was set to."""
    return {"v": true.volts + 0.15 * station.motor.R * true.current}


def switched(station: Station) -> Drive:
    """PWM of one period a sample, between the nominal voltage and a short circuit."""
    usual, volts, period = steps(station), station.motor.volts, station.period_s

    def drive(t: float, i: float, w: float) -> float:
        wish = usual(t + 1e-9, i, w) or 0.0
        on = (t / period + 1e-6) % 1.0 < abs(wish) / volts
        return float(np.copysign(volts, wish)) if on else 0.0

    return drive


def locked(true: Trace, station: Station) -> Mapping[str, Floats]:
    """Mean volts of each PWM period; current and speed at one phase of it."""
    late_by = round(PWM_LOCKED_AT * 20)
    volts = mean(true.volts, true.step_s, station.period_s, "before")
    return {"v": volts, "i": np.roll(true.current, -late_by), "w": np.roll(true.speed, -late_by)}


def at_supply(true: Trace, station: Station) -> Mapping[str, Floats]:
    """The supply's volts, which a bridge turns into the motor's by its duty and its sign."""
    return {"v": np.full(len(true.volts), station.motor.volts)}


def from_supply(true: Trace, station: Station) -> Mapping[str, Floats]:
    """The current that the bridge takes from its supply: duty times the motor's."""
    return {"i": true.current * true.volts / station.motor.volts}


def as_duty(true: Trace, station: Station) -> Mapping[str, Floats]:
    """The duty in place of volts."""
    return {"v": true.volts / station.motor.volts}


def geared(true: Trace, station: Station) -> Mapping[str, Floats]:
    """The speed of a gear's output, 14 to 1."""
    return {"w": true.speed / 14.0}


def restamped(rows: Callable[[int, Rng], Any]) -> Callable[[Table, Station, Rng], Table]:
    """Some rows of the file, under stamps that go on as if they were all."""

    def spoil(table: Table, station: Station, rng: Rng) -> Table:
        kept = rows(len(table["t"]), rng)
        out = {name: column[kept] for name, column in table.items()}
        return {**out, "t": np.arange(len(kept)) * station.period_s}

    return spoil


def some_lost(n: int, rng: Rng) -> Any:
    """One row in a hundred."""
    return np.flatnonzero(rng.random(n) > 0.01)


def stretch_cut(n: int, rng: Rng) -> Any:
    """A twentieth of the log, while the motor accelerates."""
    begin = round(0.29 * n)
    return np.concatenate([np.arange(begin), np.arange(begin + n // 20, n)])


def doubled(n: int, rng: Rng) -> Any:
    """One row in ten, twice."""
    return np.repeat(np.arange(n), 1 + (rng.random(n) < 0.1))


def magnitudes(*names: str) -> Callable[[Table, Station, Rng], Table]:
    """What an instrument without signs shows of these columns."""
    return lambda table, station, rng: table | {name: np.abs(table[name]) for name in names}


def interpolated(table: Table, station: Station, rng: Rng) -> Table:
    """A tenth of the rows, and straight lines between them."""
    t = table["t"][: (len(table["t"]) - 1) // 10 * 10 + 1]
    return {name: np.interp(t, t[::10], column[: len(t) : 10]) for name, column in table.items()}


def smoothed(table: Table, station: Station, rng: Rng) -> Table:
    """A speed that a script averaged over 41 rows around each."""
    return {**table, "w": np.convolve(table["w"], np.ones(41) / 41, "same")}


def coarse(table: Table, station: Station, rng: Rng) -> Table:
    """Readings of 8 bits, a 256th of each range."""
    scales = {"v": 2.0, "i": 2.0, "w": 2.0}
    rest = {n: rounded(table[n], k * station.scales[n] / 256) for n, k in scales.items()}
    return {**table, **rest}


def slow_clock(table: Table, station: Station, rng: Rng) -> Table:
    """Stamps of a clock that is 1 % slow."""
    return {**table, "t": 0.99 * table["t"]}


def clock_in(factor: float) -> Callable[[Table, Station, Rng], Table]:
    """Stamps in another unit."""
    return lambda table, station, rng: {**table, "t": factor * table["t"]}


def with_thousands(table: Table) -> str:
    """Speeds as a spreadsheet of another country writes them: 1.009 is a thousand and nine."""

    def cell(x: float) -> str:
        whole = f"{abs(x):,.0f}".replace(",", ".")
        return f"-{whole}" if x < 0 else whole

    rpm = np.round(table["w"] * 60 / (2 * np.pi))
    rows = zip(table["t"], table["v"], table["i"], rpm, strict=True)
    lines = [f"{t:.6g};{v:.6g};{i:.6g};{cell(n)}" for t, v, i, n in rows]
    return "\n".join(["t;v;i;n", *lines]) + "\n"


CURRENT_LATE = (r"current_lag", r"current\b[^.]*\blate\b")
SPEED_LATE = (r"speed_lag", r"speed\b[^.]*\blate\b")
CURRENT_FILTER = (r"current_filtered", r"current\b[^.]*low.pass")
SPEED_FILTER = (r"speed_filtered", r"speed\b[^.]*low.pass")
VOLTAGE_FILTER = (r"voltage_filtered", r"voltage\b[^.]*low.pass")
VOLTAGE_LATE = (r"voltage_lag", r"voltage\b[^.]*\blate\b")
ZERO = (r"current_offset", r"current\b[^.]*\b(offset|zero)\b")
TIME_UNIT = (r"\btime\b[^.]*(\b(unit|ms|milliseconds)\b|counts the rows)",)
OPENED = (r"bridge\b[^.]*\bopen", r"\bcoast", r"open[^.]*bridge")
REPEATED = (r"readings_held", r"(repeated|held|doubled|duplicate)")
LOST = (r"samples_dropped", r"(samples|rows)\b[^.]*(lost|missing)", r"\bjump")
RPM = 60 / (2 * np.pi)


def _scale(names: str, words: str) -> tuple[str, ...]:
    return (rf"({names})_scale", rf"\b({names})\b[^.]*\b({words})\b")


MISTAKES = (
    Mistake("amperes mapped as mA", _scale("current", "mA|unit|1000|thousand"),
            Log(maps={"current": "i:mA"}, plate=True)),
    Mistake("mA mapped as amperes", _scale("current", "mA|unit|1000|thousand"),
            Log(chain={"i": times(1e3)}, plate=True)),
    Mistake("seconds mapped as ms", TIME_UNIT,
            Log(maps={"time": "t:ms"}, plate=True)),
    Mistake("ms mapped as seconds", TIME_UNIT,
            Log(spoil=clock_in(1e3), plate=True)),
    Mistake("rpm mapped as rad/s", _scale("speed", "rpm|unit"),
            Log(chain={"w": times(RPM)}, plate=True)),
    Mistake("deg/s mapped as rad/s", _scale("speed", "deg|deg/s|unit"),
            Log(chain={"w": times(180 / np.pi)}, plate=True)),
    Mistake("mV mapped as V", _scale("voltage", "mV|unit"),
            Log(chain={"v": times(1e3)}, plate=True)),
    Mistake("probe of 10:1 not stated", _scale("voltage", "factor|gain|10"),
            Log(chain={"v": times(0.1)}, plate=True)),
    Mistake("shunt wrong by 2", _scale("current", "factor|gain|2"),
            Log(chain={"i": times(2.0)}, plate=True)),
    Mistake("current gain 2 % off, none stated", (r"not stated: .*current",),
            Log(chain={"i": times(1.02)}), traceless=("current_scale",)),
    Mistake("speed of a gear's output", (r"speed_scale", r"\bgear"),
            Log(source=geared, plate=True)),
    Mistake("current and voltage swapped", (r"swapped", r"voltage and current|current and voltage"),
            Log(maps={"voltage": "i:V", "current": "v:A"})),
    Mistake("speed and voltage swapped", (r"swapped", r"voltage and speed|speed and voltage"),
            Log(maps={"voltage": "w:V", "speed": "v:rad/s"})),
    Mistake("current reversed", (r"current_sign", r"sign of the current"),
            Log(maps={"current": "-i:A"})),
    Mistake("encoder reversed", (r"(encoder|speed)_sign", r"sign of the (speed|encoder)"),
            Log(maps={"speed": "-w:rad/s"})),
    Mistake("voltage reversed", (r"voltage_sign", r"sign of the voltage"),
            Log(maps={"voltage": "-v:V"})),
    Mistake("current offset, .2 % of stall", ZERO,
            Log(drive=one_way, chain={"i": offset(0.002)})),
    Mistake("current offset, 2 % of stall", ZERO,
            Log(chain={"i": offset(0.02)})),
    Mistake("current filtered, 3 samples", CURRENT_FILTER, Log(chain={"i": filtered(3)})),
    Mistake("current filtered, 2nd order", CURRENT_FILTER, Log(chain={"i": filtered(3, 2)})),
    Mistake("speed filtered, 20 samples", SPEED_FILTER, Log(chain={"w": filtered(20)})),
    Mistake("voltage filtered, 5 samples", VOLTAGE_FILTER, Log(chain={"v": filtered(5)})),
    Mistake("everything filtered, 10 samples", (*CURRENT_FILTER, *SPEED_FILTER, *VOLTAGE_FILTER),
            Log(chain={n: filtered(10) for n in "viw"})),
    Mistake("current late, 10 samples", CURRENT_LATE, Log(chain={"i": lagging(10)})),
    Mistake("speed late, 5 samples", SPEED_LATE, Log(chain={"w": lagging(5)})),
    Mistake("voltage late, 5 samples", VOLTAGE_LATE,
            Log(chain={"v": lagging(5)})),
    Mistake("current of means over 4 samples",
            (r"current\b[^.]*\b(mean|average|aperture)", *CURRENT_LATE, *CURRENT_FILTER),
            Log(chain={"i": averaged(4)})),
    Mistake("speed smoothed afterwards, 41 rows",
            (*SPEED_FILTER, r"speed\b[^.]*\b(smooth|average|mean|aperture)"),
            Log(spoil=smoothed)),
    Mistake("bridge opens, not said", OPENED,
            Log(drive=coasting)),
    Mistake("bridge opens, 0 V logged", OPENED,
            Log(drive=coasting, source=unseen)),
    Mistake("supply logged, not the terminals", (r"supply", r"terminals"),
            Log(drive=one_way, source=at_supply)),
    Mistake("set volts logged, the supply sags", (r"supply", r"series_resistance", r"terminals"),
            Log(drive=sagging, source=unloaded, plate=True)),
    Mistake("supply's current logged", (r"supply", r"\bbridge\b[^.]*current"),
            Log(drive=one_way, source=from_supply, plate=True)),
    Mistake("duty mapped as V", (r"voltage_scale", r"\bduty\b", r"voltage\b[^.]*\bunit"),
            Log(source=as_duty, plate=True)),
    Mistake("rows doubled, stamps renewed", REPEATED,
            Log(spoil=restamped(doubled))),
    Mistake("rows lost, stamps renewed", LOST,
            Log(spoil=restamped(some_lost))),
    Mistake("a stretch cut out, stamps renewed",
            LOST,
            Log(spoil=restamped(stretch_cut))),
    Mistake("speed without its sign", (r"magnitude",), Log(spoil=magnitudes("w"))),
    Mistake("current and speed without signs", (r"magnitude",), Log(spoil=magnitudes("i", "w"))),
    Mistake("interpolated from a tenth", (r"interpolat", r"straight lines", r"resampl"),
            Log(spoil=interpolated)),
    Mistake("current clipped at half", (r"current_saturated", r"saturat", r"clipp"),
            Log(chain={"i": clipped(0.5)})),
    Mistake("8-bit readings", (r"resolution", r"quanti[sz]", r"coarse"), Log(spoil=coarse)),
    Mistake("thousands marks", (r"thousand", r"1\.\d\d\d"),
            Log(write=with_thousands, maps={"speed": "n:rpm"})),
    Mistake("clock 1 % slow", (r"clock", r"time base"), Log(spoil=slow_clock),
            traceless=("clock", "time_scale")),
    Mistake("sampling locked to the PWM", (r"\bPWM\b", r"alias"),
            Log(drive=switched, source=locked)),
    Mistake("few samples a motion", (r"slow_sampling", r"few[ _]samples", r"\brate\b", r"coarse"),
            Log(every_tau=0.6)),
    Mistake("leads not stated", (r"series_resistance", r"leads?\b[^.]*resistance"),
            Log(source=lambda true, s: {"v": true.volts + 0.4 * s.motor.R * true.current},
                plate=True)),
)  # fmt: skip
