"""What a supply behind a resistance and a capacitor does, against its differential equation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.estimate.signals.source import supply_sag
from motorid.estimate.signals.source.current_transient import PLACES, Rise
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.signals.source.supply_sag import TELLING, Draw, Draws, seen
from motorid.estimate.signals.time_grid import Part
from motorid.estimate.signals.voltage_window import Window
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]
DUTY, VOLTS, SLOW = StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS, Decay.SYNCHRONOUS_SLOW
EVEN = np.full(len(PLACES), 1.0 / len(PLACES))
N = 160  # intervals of a part
FINE = 256  # steps of an interval


def part(level: float, start: int = 50, kind: StepKind = DUTY, decay: Decay = SLOW) -> Part:
    return Part(start, start + N, kind, level, decay)


def follows(drawn: Floats, before: float, late: float) -> Floats:
    """(n, FINE + 1): what follows a current that is constant in each of FINE steps of n intervals,
    by a lateness in intervals.
    """
    keep = np.exp(-1.0 / (late * FINE))
    out, now = np.zeros((len(drawn), FINE + 1)), before
    for k, current in enumerate(drawn):
        out[k, 0] = now
        for j in range(FINE):
            now = keep * now + (1.0 - keep) * current[j]
            out[k, j + 1] = now
    return out


def over(values: Floats, start: float = 0.0, stop: float = 1.0) -> Floats:
    """Means (n,) from ``start`` to ``stop`` of every interval."""
    at = np.arange(FINE + 1) / FINE
    if stop <= start:
        return np.array([np.interp(stop, at, one) for one in values])
    inside = np.linspace(start, stop, 400)
    return np.array([np.interp(inside, at, one).mean() for one in values])


@pytest.mark.parametrize("late", [0.3, 2.0, 9.0])
@pytest.mark.parametrize(("start", "stop"), [(0.0, 1.0), (0.4, 0.9), (0.7, 0.7)])
def test_means_of_what_follows_a_current(late: float, start: float, stop: float) -> None:
    current = np.array([2.0, -1.0, 0.5])
    ran = follows(np.repeat(current[:, None], FINE, axis=1), 0.3, late)
    begin = np.concatenate([[0.3], ran[:-1, -1]])
    found = supply_sag._mean(current, begin, late, start, stop)
    assert found == pytest.approx(over(ran, start, stop), abs=2e-3)
    whole = np.concatenate([[0.3], current])
    assert whole @ supply_sag._behind(3, late) == pytest.approx([*begin, ran[-1, -1]], rel=1e-6)


def transient(first: float, last: float) -> tuple[Rise, Floats, Floats]:
    """A current from one level to another: its first intervals in places, means, and fine steps."""
    at = (np.arange(N * FINE) + 0.5) / FINE
    fine = (last + (first - last) * np.exp(-at / 3.0)).reshape(N, FINE)
    each = FINE // len(PLACES)
    amperes = fine[:HEAD].reshape(HEAD, len(PLACES), each).mean(axis=2)
    return Rise(part(0.5), amperes, EVEN), fine.mean(axis=1), fine


@pytest.mark.parametrize("late", [0.5, 4.0])
@pytest.mark.parametrize(
    "window", [Window(1e-4), Window(1e-4, 6e-5, 2e-5), Window(1e-4, 0.0, 3e-5)]
)
def test_a_duty_lets_through_what_its_share_draws(late: float, window: Window) -> None:
    """v = -share² · what follows the current, an ohm behind the capacitor."""
    rise, means, _ = transient(0.2, 3.0)
    mean = np.concatenate([np.full(50, 0.6), means])
    here, earlier = part(0.5), part(0.8, 10)
    draw = Draw.of(here, earlier, replace(rise, part=here), mean, 12.0)
    assert draw is not None
    assert (draw.share, draw.follows, draw.before) == pytest.approx((0.5, 0.0, 0.8 * 0.6))
    steps = np.repeat(0.5 * rise.amperes, FINE // len(PLACES), axis=1)
    after = np.repeat(0.5 * means[HEAD:TELLING, None], FINE, axis=1)
    ran = follows(np.concatenate([steps, after]), 0.8 * 0.6, late)
    shown, taken = Draws([draw], window, EVEN).sags(late)
    stop = 1.0 - window.delay_s / 1e-4
    start = stop - window.aperture_s / 1e-4
    assert taken[0] == pytest.approx(-0.5 * over(ran), abs=5e-3)
    near = 5e-3 if window.aperture_s or stop == 1.0 else 2e-2
    assert shown[0][HEAD:] == pytest.approx(-0.5 * over(ran, start, stop)[HEAD:], abs=near)
    assert shown[0][1:HEAD] == pytest.approx(-0.5 * over(ran, start, stop)[1:HEAD], abs=0.06)


def test_the_whole_of_a_part_goes_on_where_its_first_readings_end() -> None:
    rise, means, _ = transient(0.2, 3.0)
    wavy = means + 0.3 * np.sin(np.arange(N))
    mean = np.concatenate([np.full(50, 0.6), wavy])
    here = part(0.5)
    draw = Draw.of(here, part(0.8, 10), replace(rise, part=here), mean, 12.0)
    assert draw is not None
    window = Window(1e-4)
    rows = np.zeros(TELLING), np.ones(TELLING)
    shown, taken = draw.whole(rows, wavy, 4.0, window)
    assert not shown[:TELLING].any()
    assert (taken[:TELLING] == 1.0).all()
    ran = follows(np.repeat(0.5 * wavy[:, None], FINE, axis=1), 0.8 * 0.6, 4.0)
    assert taken[TELLING:] == pytest.approx(-0.5 * over(ran)[TELLING:], abs=2e-3)
    assert shown[TELLING:] == pytest.approx(-0.5 * ran[TELLING:, -1], abs=2e-3)


@pytest.mark.parametrize(
    ("level", "decay", "share", "given"),
    [(6.0, SLOW, 0.5, 0.5), (-6.0, SLOW, -0.5, -0.5), (9.0, Decay.DIODE, 0.5, 1.5),
     (-9.0, Decay.DIODE, -0.5, -1.5)],
)  # fmt: skip
def test_volts_are_made_up_for_by_the_duty_of_the_next_sample(
    level: float, decay: Decay, share: float, given: float
) -> None:
    """With diodes the motor gets (2 d - 1) of the supply, and a change of d counts twice."""
    rise, means, _ = transient(0.2, 3.0)
    here = part(level, kind=VOLTS, decay=decay)
    mean = np.concatenate([np.full(50, 0.6), means])
    draw = Draw.of(here, Part(0, 50, StepKind.COAST), replace(rise, part=here), mean, 12.0)
    assert draw is not None
    assert (draw.share, draw.follows, draw.before) == pytest.approx((share, given, 0.0))
    assert draw.first == pytest.approx(share * rise.amperes.ravel())
    assert draw.after == pytest.approx(share * means[HEAD:TELLING])
    shown, _ = Draws([draw], Window(1e-4), EVEN).sags(4.0)
    alone, _ = Draws([replace(draw, follows=0.0)], Window(1e-4), EVEN).sags(4.0)
    supply = alone[0] / -share
    made_up = given * np.concatenate([[0.0], supply[:-1]])
    assert shown[0] == pytest.approx(made_up + alone[0])


def test_a_part_that_is_short_or_in_pulses_tells_nothing() -> None:
    rise, means, _ = transient(0.2, 3.0)
    mean = np.concatenate([np.full(50, 0.6), means])

    def drawn(here: Part, rail: float | None = 12.0) -> Draw | None:
        return Draw.of(here, part(0.8, 10), replace(rise, part=here), mean, rail)

    assert drawn(replace(part(0.5), stop=50 + 24)) is not None
    assert drawn(replace(part(0.5), stop=50 + 23)) is None
    assert drawn(replace(part(0.5), discontinuous=True)) is None
    assert drawn(part(0.0)) is None
    assert drawn(part(6.0, kind=VOLTS), None) is None
    short = drawn(replace(part(0.5), stop=50 + 60))
    assert short is not None
    assert short.after[60 - HEAD :] == pytest.approx(0.5 * means[59])  # it stays


@pytest.mark.parametrize(
    ("window", "start", "stop"),
    [
        (Window(1e-4), 1.0, 1.0),
        (Window(1e-4, 5e-5, 2e-5), 0.3, 0.8),
        (Window(1e-4, 9e-5, 3e-5), 0.0, 0.7),
    ],
)
def test_a_reading_sees_the_places_of_its_window(window: Window, start: float, stop: float) -> None:
    assert supply_sag._reach(window) == pytest.approx((start, stop))
    share = seen(window)
    assert share.sum() == pytest.approx(1.0)
    inside = (start - 1 / 16 < PLACES) & (stop + 1 / 16 > PLACES)
    assert not share[~inside].any()
    middle = (start + 1 / 16 < PLACES) & (stop - 1 / 16 > PLACES)
    if middle.any():
        assert share[middle] == pytest.approx(1 / 16 / (stop - start))


def readings(ohms: float, noise: float, late: float = 4.0) -> Floats:
    """Open-circuit readings of a part behind such a supply, and its line in the current."""
    rise, means, _ = transient(0.2, 3.0)
    mean = np.concatenate([np.full(50, 0.6), means])
    here = part(0.5)
    draw = Draw.of(here, Part(0, 50, StepKind.COAST), replace(rise, part=here), mean, 12.0)
    assert draw is not None
    window = Window(1e-4)
    shown, taken = Draws([draw], window, EVEN).sags(late)
    whole, _ = draw.whole((shown[0], taken[0]), means, late, window)
    rng = np.random.default_rng(3)
    volts = 6.0 + 0.2 * means + ohms * whole + noise * rng.standard_normal(N)
    return np.concatenate([np.zeros(50), volts])


def told(volts: Floats, **how: object) -> dict[int, supply_sag.Sag]:
    rise, means, _ = transient(0.2, 3.0)
    mean = np.concatenate([np.full(50, 0.6), means])
    parts = [Part(0, 50, StepKind.COAST), part(0.5)]
    known = np.ones(50 + N, dtype=bool)
    found = supply_sag.sags(
        Window(1e-4), parts, volts, mean, known, mean, [replace(rise, part=parts[1])], 12.0, **how
    )  # type: ignore[arg-type]
    return dict(found)


def test_a_supply_is_told_by_its_own_course() -> None:
    late = supply_sag.LATENESS[6]
    sag = told(readings(0.8, 1e-4, late))[1]
    assert sag.late == late
    again = told(readings(0.8, 1e-4, late), before={1: sag})[1]
    assert again.late == late
    _, means, _ = transient(0.2, 3.0)
    left = readings(0.8, 0.0, late)[50:] - 6.0 - 0.2 * means
    assert sag.shown == pytest.approx(left, abs=0.01)


def test_a_supply_that_is_stiff_or_unclear_is_left_alone() -> None:
    assert told(readings(0.0, 1e-3)) == {}
    assert told(readings(0.8, 1.0)) == {}
    assert told(readings(-0.8, 1e-4)) == {}  # it would push
    assert told(readings(0.8, 1e-4), before={}) == {}
