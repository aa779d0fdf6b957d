"""Steps that hold channels against references: rest, gains at driven levels, the supply."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from motorid.calibration.gain import Gain, Meter, Point, gain_of
from motorid.calibration.rest import Zero, rest_of
from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE
from motorid.errors import DataError, RigError
from motorid.workflow.calibrate.bench import Bench, Tables, now
from motorid.workflow.calibrate.person import Reference, Resistor

if TYPE_CHECKING:
    from motorid.acquire.session import Level, Session

ZEROED = {CURRENT: "current", VOLTAGE: "voltage"}  # as the reply to zero names them
SHARES = (-1.0, -0.5, 0.5, 1.0)  # of the largest level
LARGEST = 0.5  # of limits.current_a
HEADROOM = 0.9  # of the supply
EXACT = 1e-9  # A or V: what stands in for a meter without a term of its own
INSTANT = (
    "this channel is read at an instant of the PWM period, and a meter shows the mean: with a "
    "resistor the two differ by the ripple, so clamp a motor, whose inductance smooths it"
)


def rest(bench: Bench) -> Tables:
    """Zero offset of current and voltage: many readings, their standard error, and drift."""
    tables: Tables = {}
    with bench.session("free") as session:
        zeros: dict[str, list[Zero]] = {name: [] for name in ZEROED if name in session.facts}
        for _ in range(bench.settings.zeros):
            time_s = session.port.now()
            reply, samples = session.zero()
            for name, own in zeros.items():
                key = ZEROED[name]
                own.append(Zero(time_s, reply[f"{key}_offset"], reply[f"{key}_noise"], samples))
            session.board.wait(bench.settings.rest_s / bench.settings.zeros)
        for name, own in zeros.items():
            found, scale = rest_of(own), abs(session.facts[name]["scale"])
            unit = "A" if name == CURRENT else "V"
            tables[name] = {
                "rest_date": now(),
                "rest_offset_counts": found.offset,
                "rest_standard_error_counts": found.standard_error,
                "rest_noise_counts": found.noise,
                "rest_drift_counts_minute": found.drift_per_minute,
                "rest_drift_uncertainty_counts_minute": found.drift_uncertainty,
                "offset_uncertainty": found.uncertainty * scale,
            }
            bench.person.say(
                f"{name} at rest: {found.offset:.2f} ± {2 * found.standard_error:.2f} counts; a "
                f"run's own zero is right to {2 * found.uncertainty * scale:.2g} {unit} (95 %)"
            )
            if found.drifts:
                bench.person.say(
                    f"  it drifts {found.drift_per_minute:+.2f} counts a minute: let the sensor "
                    "warm up, and calibrate again"
                )
    return tables


def gain(name: str) -> Callable[[Bench], Tables]:
    """The step that finds the gain of the current or of the terminal voltage at driven levels."""

    def step(bench: Bench) -> Tables:
        reference = bench.person.reference(name)
        with bench.session("load") as session:
            points = list(_points(bench, session, name, reference))
        return {name: _gain_table(bench, name, points, reference)}

    return step


def _points(bench: Bench, session: Session, name: str, reference: Reference) -> Iterator[Point]:
    """One point a level; every level is announced before it is driven."""
    from motorid.acquire.pulse import MOVED
    from motorid.wire.enums import ChannelKind

    if name not in session.facts:
        raise DataError(f"the board has no channel {name}: skip this step")
    bench.person.proceed(
        "a pulse of a tenth of the supply, at most 0.3 s, to see what is connected"
    )
    pulse = session.pulse()
    if not pulse.draws or pulse.current_a is None:
        raise RigError("no current flows: connect the load, and check the bridge's enable")
    if abs(pulse.counts) >= MOVED:
        raise RigError("the shaft turns: clamp it, or put a resistor in place of the motor")
    if session.facts[name]["kind"] == ChannelKind.INSTANT:
        bench.person.say(INSTANT)
    ohm = abs((pulse.voltage_v or pulse.volts) / pulse.current_a)
    for number, volts in enumerate(levels(bench, session, ohm)):
        what = f"{volts:+.2f} V for {bench.settings.hold_s:g} s, about {volts / ohm:+.2f} A"
        bench.person.proceed(f"level {number + 1}: {what}; read the meter in its second half")
        held = session.hold(volts, bench.settings.hold_s, pulse)
        own, own_u = _si(session, name, held[name])
        if isinstance(reference, Meter):
            shown = bench.person.reading(name, number, what)
            yield Point(own, own_u, shown, max(reference.apart, EXACT))
        else:
            across, across_u = _si(session, VOLTAGE, held[VOLTAGE])
            factor = float(bench.found.get(VOLTAGE, {}).get("gain", 1.0)) / reference.ohm
            yield Point(own, own_u, across * factor, across_u * factor)


def levels(bench: Bench, session: Session, ohm: float) -> tuple[float, ...]:
    """Volts of the levels: as set, or both ways up to half the current limit."""
    if bench.settings.levels_v:
        return bench.settings.levels_v
    supply = session.board.supply_v() or session.rig.supply_voltage_v or 0.0
    top = min(LARGEST * session.rig.limits.current_a * ohm, HEADROOM * supply)
    return tuple(round(share * top, 2) for share in SHARES)


def _si(session: Session, name: str, level: Level) -> tuple[float, float]:
    """A level in A or V by the board's own scale, zeroed, with its standard uncertainty."""
    scale, key = session.facts[name]["scale"], ZEROED[name]
    zero = session.last_zero
    noise = zero[f"{key}_noise"] / session.zero_samples**0.5
    value = scale * (level.mean - zero[f"{key}_offset"])
    return value, abs(scale) * (level.uncertainty**2 + noise**2) ** 0.5


def _common(bench: Bench, reference: Reference) -> float:
    """Relative standard uncertainty that all points of a reference share."""
    if isinstance(reference, Meter):
        return reference.common
    volts = bench.found.get(VOLTAGE, {}).get("gain_uncertainty")
    if volts is None:
        raise DataError(
            "a known resistor needs the voltage calibrated first: do the step terminal_voltage, "
            "or use a meter"
        )
    return float(((reference.uncertainty_ohm / reference.ohm) ** 2 + volts**2) ** 0.5)


def _gain_table(
    bench: Bench, name: str, points: list[Point], reference: Reference
) -> dict[str, Any]:
    unit = "A" if name == CURRENT else "V"
    found = gain_of(points, _common(bench, reference))
    _say_gain(bench, name, found, unit)
    return {
        "date": now(),
        "gain": found.gain,
        "gain_uncertainty": found.uncertainty,
        "zero": found.zero,
        "zero_uncertainty": found.zero_uncertainty,
        "excess": found.excess,
        **_instrument(reference),
        "points": [
            [p.reading, p.reading_uncertainty, p.reference, p.reference_uncertainty] for p in points
        ],
    }


def _say_gain(bench: Bench, name: str, found: Gain, unit: str) -> None:
    bench.person.say(
        f"{name}: gain {found.gain:.5f} ± {2 * found.uncertainty * found.gain:.5f} (95 %) of the "
        "board's own scale"
    )
    for finding in found.findings(unit):
        bench.person.say(f"  {finding}")


def _instrument(reference: Reference) -> dict[str, Any]:
    common = {"instrument": reference.name, "instrument_serial": reference.serial}
    if isinstance(reference, Resistor):
        load = {"load_ohm": reference.ohm, "load_uncertainty_ohm": reference.uncertainty_ohm}
        return {"method": "known resistor", **common, **load}
    return {"method": "meter", **common, "accuracy": reference.accuracy}


def supply(bench: Bench) -> Tables:
    """Gain and offset of the supply's divider, at settings of the supply, the bridge open."""
    reference = bench.person.reference(SUPPLY)
    if isinstance(reference, Resistor):
        raise DataError("the supply is held against a meter, not a resistor")
    with bench.session("free") as session:
        if SUPPLY not in session.facts:
            raise DataError("the board does not measure its supply: skip this step")
        fact = session.facts[SUPPLY]
        points = []
        for number in range(bench.person.levels(SUPPLY)):
            what = f"set the supply to level {number + 1}, within its limits, and read the meter"
            shown = bench.person.reading(SUPPLY, number, what)
            level = session.resting(SUPPLY, 1.0)
            points.append(
                Point(
                    fact["scale"] * (level.mean - fact["offset"]),
                    abs(fact["scale"]) * level.uncertainty,
                    shown,
                    max(reference.apart, EXACT),
                )
            )
    table = _gain_table(bench, SUPPLY, points, reference)
    table["offset_counts"] = fact["offset"] + table["zero"] / fact["scale"]
    table["offset_uncertainty"] = table["zero_uncertainty"] * table["gain"]
    return {SUPPLY: table}
