"""The steps of a calibration by name: what each does, and what the bench must look like for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from motorid.acquire.clock import Clock, Pair, clock_of, with_stated
from motorid.calibration.encoder import encoder_of
from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE
from motorid.workflow.calibrate.bench import Bench, Tables, now
from motorid.workflow.calibrate.disc import disc
from motorid.workflow.calibrate.gains import gain, rest, supply


def encoder(bench: Bench) -> Tables:
    """Counts a turn, by hand: so many turns there, and back to the mark."""
    turns, declared = bench.settings.turns, bench.rig.wiring.counts_per_turn
    with bench.session("free") as session:
        start = session.board.position()
        bench.person.turn(turns)
        session.board.wait(0.2)
        far = session.board.position()
        bench.person.turn(-turns)
        session.board.wait(0.2)
        found = encoder_of(far - start, session.board.position() - far, turns, declared)
    bench.person.say(
        f"encoder: {found.per_turn:.1f} ± {2 * found.uncertainty:.1f} counts a turn (95 %), the "
        f"rig says {declared:g}; there and back differ by {found.lost:+.0f} counts"
    )
    for finding in found.findings():
        bench.person.say(f"  {finding}")
    return {
        "encoder": {
            "date": now(),
            "counts_per_turn": found.per_turn,
            "uncertainty": found.uncertainty,
            "turns": float(turns),
            "lost_counts": found.lost,
        }
    }


def clock(bench: Bench) -> Tables:
    """The board's clock against this computer's."""
    from motorid.acquire.clock_check import of_identity

    settings = bench.settings
    with bench.session("free") as session:
        pairs = session.ticks(settings.clock_s, settings.clock_pairs)
        nominal, stated, _ = of_identity(session.board.identity)
    measured = clock_of([Pair(*one) for one in pairs], nominal, settings.host_uncertainty)
    found = with_stated(measured, stated)
    bench.person.say(
        f"clock: measured {_ppm(measured)}; with the board's own 0 ± {2e6 * stated:.0f}: "
        f"{_ppm(found)} (95 %) off its nominal {nominal:g} Hz"
    )
    return {
        "clock": {
            "date": now(),
            "rate": found.rate,
            "uncertainty": found.uncertainty,
            "host_uncertainty": settings.host_uncertainty,
            "span_s": found.span_s,
            "pairs": found.pairs,
        }
    }


def _ppm(clock: Clock) -> str:
    return f"{(clock.rate - 1) * 1e6:+.1f} ± {2e6 * clock.uncertainty:.1f} ppm"


STEPS: Mapping[str, tuple[Callable[[Bench], Tables], str]] = {
    "rest": (rest, "leave the motor connected and at rest, the sensors warm"),
    VOLTAGE: (
        gain(VOLTAGE),
        "put a resistor in place of the motor, or clamp the shaft; a meter for DC across the "
        "points where the terminal voltage is sensed",
    ),
    CURRENT: (
        gain(CURRENT),
        "put a resistor in place of the motor, or clamp the shaft; a meter for DC in series, or a "
        "resistor that is known",
    ),
    SUPPLY: (supply, "a meter across the bridge's supply, which can be set to several voltages"),
    "encoder": (encoder, "mark the shaft, to turn it by hand"),
    "clock": (clock, "nothing to do; it takes half a minute"),
    "disc": (disc, "the motor free, and a disc of known inertia that fits its shaft"),
}
