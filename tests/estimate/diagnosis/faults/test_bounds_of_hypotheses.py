"""Where a hypothesis begins, and which way it acts, by records and readings made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.faults import (
    channel_delay,
    decay_mode,
    encoder_bandwidth,
    load_slip,
    lost_rows,
    model_alternatives,
    scale_errors,
    unstated_channels,
)
from motorid.estimate.diagnosis.faults.filters import low_pass_filter
from motorid.estimate.diagnosis.faults.lost_rows import _even, _Lines, _peaks, _step
from motorid.estimate.diagnosis.faults.readings import repeated_readings
from motorid.estimate.diagnosis.faults.zeros import current_zero
from motorid.estimate.effects.brush_and_heating import DROP, WARMING
from motorid.estimate.effects.source.brush_drop import BRUSH_DROP
from motorid.estimate.effects.source.winding_warming import WINDING_WARMING
from motorid.estimate.fit.block_regression import Blocks
from motorid.estimate.signals.neighbour_noise import neighbour_noise
from motorid.program import Decay, StepKind
from tests.estimate.effects.benches import driven

# ---------------------------------------------------------------- a bridge's decay


def test_another_decay_acts_as_its_response_less_the_usual_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Judged once, where it is first tried; by as much of it as its size says."""
    judged: list[Any] = []

    class Under:
        excitation = "other"

        def judged(self, course: Any, losing: Any) -> Under:
            judged.append((course, losing))
            return self

    def under(record: Any, capture: Any) -> Under:
        assert {s.decay for s in capture.program.steps if s.level} == {Decay.FAST}
        return Under()

    monkeypatch.setattr(decay_mode, "_under", under)
    other = SimpleNamespace(fitted=lambda values, own: [np.array([5.0, 7.0]), np.array([1.0])])
    record: Any = SimpleNamespace(
        capture=driven(Decay.SYNCHRONOUS_SLOW, StepKind.DRIVE_VOLTS), losing="losses",
        course=lambda values, own: (values, own),
        twin=lambda excitation: {"other": other}[excitation],
        fitted=lambda values, own: [np.array([4.0, 3.0]), np.array([2.0])],
    )  # fmt: skip
    one = decay_mode._hypothesis(Decay.SYNCHRONOUS_SLOW, Decay.FAST)
    values: Any = "values"
    own: Any = "own"
    for size in (1.0, 0.5):
        current, speed = one.effect(record, values, own, np.array([size]))
        assert current == pytest.approx([size, 4.0 * size])
        assert speed == pytest.approx([-size])
    assert judged == [(("values", "own"), "losses")]
    assert (one.lower, one.upper) == (pytest.approx((0.7,)), pytest.approx((1.3,)))


def test_every_record_must_tell_two_modes_apart() -> None:
    """Volts that are commanded in one, and read at the motor in the other, tell no pair."""
    capture = driven(Decay.SYNCHRONOUS_SLOW, StepKind.DRIVE_VOLTS)
    commanded, read = (
        SimpleNamespace(capture=capture, sensed=SimpleNamespace(commanded=c, shows_emf=not c))
        for c in (True, False)
    )
    each: list[Any] = [commanded, read]
    assert [len(decay_mode.hypotheses([one])) for one in each] == [1, 1]
    assert decay_mode.hypotheses(each) == []


# ---------------------------------------------------------------- readings that repeat


def places(*shares: float, groups: int = 200) -> Any:
    """Whether neighbours are equal, at each place of a repeat in such a share of them."""
    equal = np.zeros((groups, len(shares)), dtype=bool)
    for k, share in enumerate(shares):
        equal[: round(share * groups), k] = True
    return equal.ravel()


@pytest.mark.parametrize(
    ("shares", "repeat"),
    [
        ((0.0, 1.0), 2), ((0.69, 1.0), 2), ((0.71, 1.0), 0),  # they are equal anyway
        ((0.0, 0.98), 2), ((0.0, 0.96), 0),  # now and then one is not repeated
        ((0.68, 0.975), 0), ((0.66, 0.975), 2),  # hardly more often than by chance
        ((1.0, 0.0, 1.0), 3), ((1.0, 0.0, 0.96), 0), ((0.5, 0.5), 0),
    ],
)  # fmt: skip
def test_each_reading_comes_several_times_where_all_but_one_place_are_equal(
    shares: tuple[float, ...], repeat: int
) -> None:
    assert repeated_readings._repeat(places(*shares)) == repeat


def test_sixty_four_conversions_show_a_repeat() -> None:
    assert repeated_readings._repeat(places(0.0, 1.0, groups=64)) == 2
    assert repeated_readings._repeat(places(0.0, 1.0, groups=63)) == 0


def test_a_run_is_of_six_or_more() -> None:
    equal = np.array([1] * 5 + [0] + [1] * 6 + [0, 0] + [1] * 9 + [0] + [1] * 5, dtype=bool)
    starts, lengths = repeated_readings._runs(equal)
    assert (list(starts), list(lengths)) == ([6, 14], [6, 9])


def held(raw: Any) -> tuple[int, int]:
    """How many readings repeat, and where the first does."""
    found = repeated_readings._of(Channel(CURRENT, "A", raw, scale=0.01, resolution=0.01))
    return (found.stuck, found.first) if found is not None else (0, -1)


def noise(count: int, spread: float = 1.0) -> Any:
    """Counts whose neighbours are equal in three of ten, and seldom beyond two codes in turn."""
    return np.round(2000.0 + np.random.default_rng(4).normal(0.0, spread, count))


def test_a_stretch_is_judged_by_sixty_four_readings_on_either_side() -> None:
    """Wherever it lies."""
    for place in (100, 1000, 1900):
        raw = noise(2000)
        raw[place - 2 : place + 21] = [1990, *[2001] * 21, 2010]
        assert held(raw) == (20, place - 1)


@pytest.mark.parametrize(("around", "told"), [(34, True), (30, False)])
def test_thirty_two_readings_around_show_how_often_neighbours_are_equal(
    around: int, told: bool
) -> None:
    raw = noise(around + 25, 6.0)
    raw[8:35] = [1990, *[2001] * 25, 2010]
    assert held(raw) == ((24, 9) if told else (0, -1))


@pytest.mark.parametrize(("length", "told"), [(7, False), (16, True)])
def test_a_stretch_is_longer_than_chance_makes_one_in_the_whole_capture(
    length: int, told: bool
) -> None:
    """Of two thousand readings, .3 of whose neighbours are equal: .3^7 · 2000 is a half."""
    raw = noise(2000)
    raw[1000 : 1000 + length] = raw[999]
    assert (held(raw)[0] > 0) is told


# ---------------------------------------------------------------- scales of a winding


def test_windings_of_one_slot_and_leads_obey_their_laws() -> None:
    """N times the turns of a wire N times thinner: K as N, R and L as N²; friction, and so the
    torque at no load, stays, and its current goes as 1/N. Leads add to R alone."""
    turns = 1.7
    of = {n: turns**power for n, power in scale_errors.WINDING.powers.items()}
    assert of["K"] * of[scale_errors.NO_LOAD] == pytest.approx(1.0)
    assert of["R"] == of["L"] == pytest.approx(of["K"] ** 2) == pytest.approx(turns**2)
    assert set(of) == {"R", "L", "K", scale_errors.NO_LOAD}
    assert scale_errors.SERIES.powers == {"R": 1}


# ---------------------------------------------------------------- lines beside a place


def test_a_log_is_judged_from_eight_lines_on() -> None:
    """160 rows of a motor that gets up to speed, one of which is missing after every 25."""
    for count, found in ((160, True), (159, False)):
        at = np.arange(count) + np.cumsum(np.arange(count) % 25 == 12)
        left = np.exp(-at / 40.0)
        series = {VOLTAGE: np.full(count, 9.0), CURRENT: 3.0 * left, SPEED: 400.0 * (1.0 - left)}
        channels = {
            n: Channel(n, "", y + 1e-3 * np.random.default_rng(2).standard_normal(count))
            for n, y in series.items()
        }
        log = Capture(1000 * np.arange(count), 1e6, channels)
        assert (lost_rows.find(log) is not None) is found


def test_a_jump_is_between_two_lines_and_as_sure_as_they_are() -> None:
    """Of a ramp of 2 a row that jumps by 7 before row 12; its variance by simulation's formula."""
    values = 2.0 * np.arange(24.0) + 7.0 * (np.arange(24) >= 12)
    lines = _Lines.of(values, 6)
    assert len(lines.jump) == 13
    assert lines.jump[6] == pytest.approx(7.0)
    assert (lines.before[6], lines.after[6], lines.slope[6]) == pytest.approx((2.0, 2.0, 2.0))
    assert lines.jump[0] == pytest.approx(0.0)
    rng = np.random.default_rng(3)
    noise = rng.standard_normal(4000)
    found = _Lines.of(noise, 6)
    assert found.variance == pytest.approx(float(np.var(found.jump)), rel=0.15)
    turns = _Lines.of(np.abs(np.arange(24.0) - 12.0), 6)
    assert turns.slope[6] == 0.0  # down, then up


def test_a_small_change_of_a_coarse_channel_is_its_step() -> None:
    staircase = 0.5 * np.floor(np.arange(200.0) / 10.0)
    assert _step(staircase) == 0.5
    assert _step(np.full(9, 3.0)) == 0.0
    assert neighbour_noise(staircase, order=3) == 0.0


def test_a_peak_is_most_for_as_many_rows_as_a_line_has() -> None:
    missing = np.zeros(40)
    missing[[5, 9, 20, 27]] = [1.0, -2.0, 1.0, 1.5]
    assert [int(k) for k in np.flatnonzero(_peaks(missing, 6) & (missing != 0.0))] == [9, 20, 27]
    assert not _peaks(missing, 7)[20]


def test_a_pause_in_the_stamps_is_no_loss() -> None:
    """More than half of a period more than the others, or less, in lines of 5 on either side."""
    steps = np.ones(50)
    steps[[10, 20, 35]] = [1.4, 1.6, 0.4]
    time_s = np.concatenate([[0.0], np.cumsum(steps)])
    even = _even(time_s, 5)
    assert len(even) == 42
    assert [int(k) + 4 for k in np.flatnonzero(~even)] == [*range(16, 25), *range(31, 40)]


# ---------------------------------------------------------------- what the model lacks


def test_unknowns_of_their_own_act_for_brushes_and_warmth(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def acting(quantity: Any) -> Any:
        return lambda *given: asked.append((quantity, *given))

    monkeypatch.setattr(model_alternatives, "acting", acting)
    record: Any = SimpleNamespace(loss=SimpleNamespace(shapes={DROP: 1, WARMING: 1}))
    given: Any = (record, "values", "own", "size")
    model_alternatives.brush_drop(*given)
    model_alternatives._warming(*given)
    assert asked == [(BRUSH_DROP, *given), (WINDING_WARMING, *given)]


def ranged(*spans: float) -> list[Any]:
    """Records whose current spans so much."""
    return [
        SimpleNamespace(measured=[
            SimpleNamespace(block=SimpleNamespace(name=CURRENT), unsigned=False,
                            values=np.array([-1.0, span - 1.0])),
            SimpleNamespace(block=SimpleNamespace(name=SPEED), unsigned=False,
                            values=np.array([0.0, 900.0])),
        ])
        for span in spans
    ]  # fmt: skip


def test_a_zero_that_is_off_while_driven_is_tried_by_a_hundredth_of_the_largest_span() -> None:
    (one,) = current_zero.hypotheses(ranged(4.0, 9.0, 2.0))
    assert (one.sizes, one.scale) == (((pytest.approx(0.09),),), (pytest.approx(0.09),))
    assert (one.lower, one.upper) == ((-9.0,), (9.0,))
    assert current_zero.hypotheses(ranged(0.0)) == []
    unsigned = ranged(4.0)
    unsigned[0].measured[0].unsigned = True
    assert current_zero.hypotheses(unsigned) == []


def test_lags_and_filters_are_tried_in_samples_of_the_finest_record() -> None:
    records: list[Any] = [
        SimpleNamespace(
            timeline=SimpleNamespace(period_s=p, jitter=0.0),
            capture=SimpleNamespace(period_s=4.0 * p),
            sensed=SimpleNamespace(channel=None, shows_emf=True, waveform=None),
            measured=ranged(1.0)[0].measured, instances=(), block=lambda _: None,
        )
        for p in (2e-3, 1e-3)
    ]  # fmt: skip
    current, speed, *smoothed = low_pass_filter.hypotheses(records)
    assert {one.code for one in smoothed} == {"current_smoothed", "speed_smoothed"}
    assert [size for (size,) in current.sizes] == pytest.approx([0.5e-3, 2e-3, 6e-3, 20e-3])
    assert (current.lower[0], current.upper[0]) == pytest.approx((1e-6, 0.5))
    assert speed.code == "speed_filtered"
    said = current.words(np.array([1.5e-3]))
    assert said.evidence == "the current reads as behind a low-pass of 1500 µs (106 Hz)"
    lag, late = channel_delay.hypotheses(records)
    assert [size for (size,) in lag.sizes] == pytest.approx([0.5e-3, 2e-3, 5e-3, 12e-3])
    assert (lag.code, late.code) == ("current_lag", "speed_lag")
    assert "2000 µs later than it declares (0.5 samples)" in lag.words(np.array([2e-3])).evidence


# ---------------------------------------------------------------- loads and encoders in blocks


def test_no_load_slips_by_less_than_a_twentieth_or_where_no_motor_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By the law with what is behind: its coefficient over that of the acceleration."""
    n = 30
    b = Blocks(np.ones(n), np.ones(n), np.ones(n), np.linspace(0.0, 50.0, n), np.ones(n, bool),
               np.ones(n, bool), (slice(0, n),), np.array([1e-3]))  # fmt: skip
    tried: list[float] = []

    def start(share: float, left: float, first: float = 2.0) -> Any:
        tried.clear()

        def squares(columns: Any, target: Any) -> Any:
            if columns.shape[1] == 3:
                return 100.0, np.zeros(3), None
            best = len(tried) == 5
            found = np.array([first, 3.0, -4.0, share * first])
            return left if best else 99.0, found if best else np.zeros(4), None

        def behind(_: Any, rate: float) -> Any:
            tried.append(rate)
            return np.zeros(n)

        monkeypatch.setattr(load_slip, "squares", squares)
        monkeypatch.setattr(load_slip, "_behind", behind)
        monkeypatch.setattr(load_slip, "friction_columns", lambda _: np.zeros((n, 3)))
        return load_slip.start(b)

    monkeypatch.setattr(load_slip, "electrical", lambda *_: (1.5, 0.2))
    found = start(0.3, 80.0)
    assert found.size == pytest.approx((0.3, tried[4]))
    assert (min(tried), max(tried)) == pytest.approx((0.03 * 50.0, 0.9 * 50.0))
    assert found.motor == pytest.approx({"R": 1.5, "K": 0.2, "J": 0.4, "B": 0.6, "T0": 0.0})
    assert start(0.3, 86.0) is None  # it explains less than .15 of what is left
    assert start(0.3, 84.0) is not None
    assert start(0.04, 80.0) is None
    assert start(0.06, 80.0) is not None
    assert start(1.1, 80.0) is None
    assert start(0.3, 80.0, first=-2.0) is None
    monkeypatch.setattr(load_slip, "electrical", lambda *_: None)
    assert start(0.3, 80.0) is None


def test_an_encoder_is_outrun_where_the_back_emf_is_a_fiftieth_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """At the highest speeds, by R and K of those surely below."""
    speed = np.r_[np.linspace(10.0, 84.0, 20), np.full(10, 90.0), np.full(10, 100.0)]
    position = SimpleNamespace(block=SimpleNamespace(name="position"), resolution=1e-2)
    records: Any = [SimpleNamespace(measured=[position])]
    n = len(speed)
    for more, named in ((1.019, False), (1.021, True)):
        current = np.linspace(1.0, 2.0, n)
        volts = 2.0 * current + 0.05 * speed * np.where(speed > 97.0, more, 1.0)
        b = Blocks(volts, current, speed, np.zeros(n), np.ones(n, bool), np.ones(n, bool),
                   (slice(0, n),), np.array([1e-3]))  # fmt: skip
        monkeypatch.setattr(encoder_bandwidth, "blocks", lambda _, b=b: b)
        found = encoder_bandwidth.seen(records)
        assert (found is not None) is named
    none: Any = [SimpleNamespace(measured=[])]
    assert encoder_bandwidth.seen(none) is None


# ---------------------------------------------------------------- channels of a log


@pytest.mark.parametrize(("width_s", "said"), [(1.4e-3, False), (1.6e-3, True)])
def test_a_mean_over_more_than_one_sample_and_a_half_is_said(width_s: float, said: bool) -> None:
    channel = Channel(CURRENT, "A", np.zeros(4), kind="mean", aperture_s=width_s,
                      undeclared=("aperture",))  # fmt: skip
    record: Any = SimpleNamespace(
        block=lambda name: SimpleNamespace(channel=channel),
        sensed=SimpleNamespace(waveform=SimpleNamespace(period_s=1e-3)),
    )
    found = list(unstated_channels._averaged([record, record], {"R": 2.0}))
    assert len(found) == said
    if said:
        assert found[0].evidence.startswith(
            "the current reads as a running mean over 1.6 ms (1.6 samples of the log)"
        )
        assert found[0].action.endswith("--aperture current=1.6ms")


def test_a_lag_says_how_to_declare_it() -> None:
    late = unstated_channels._said("lag", unstated_channels.Size("position", 2e-3, 0.0), 1e-3, {})
    assert late.action.endswith("--delay position=0.002")
    assert "2 ms (2 samples of the log) later than the other channels; the fit" in late.evidence
    within = unstated_channels.Size("terminal_voltage", 0.9e-3, 0.0)
    voltage = unstated_channels._said("lag", within, 1e-3, {})
    assert voltage.code == "voltage_lag"
    assert "channels, as a mean over a sample" in voltage.evidence
    slow = unstated_channels.Size("terminal_voltage", 1.1e-3, 0.0)
    assert "as a mean" not in unstated_channels._said("lag", slow, 1e-3, {}).evidence
    smooth = unstated_channels._said("filtered", within, 1e-3, {"R": 2.0})
    assert smooth.action.endswith("--filter voltage=0.9ms")
    assert (smooth.code, smooth.without) == ("voltage_filtered", {"R": 2.0})
