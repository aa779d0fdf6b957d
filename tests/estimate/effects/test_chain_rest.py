"""The rest of the measuring chain, as declared: a bent sensor, a reference that drifts, an encoder
off its centre. Their derivatives against the physics, and fits of readings that have them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebval

from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture, Channel, Curve
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.converter_steps import CONVERTER_STEPS, steps
from motorid.estimate.effects.reading.current_nonlinearity import COURSES, CURRENT_NONLINEARITY
from motorid.estimate.effects.rotor.encoder_eccentricity import ENCODER_ECCENTRICITY
from motorid.estimate.effects.source.reference_drift import REFERENCE_DRIFT
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from motorid.estimate.signals.measurements import EMF
from tests.estimate.effects.benches import POINT, moved, record, start, ticks, usual, within
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit

FULL_A = 4.0
CLEAN = Plan(volts=(6.0, 3.0, 1.5))
SMALL = np.linspace(-1.0, 1.0, 201)


def run(**wiring: float) -> Capture:
    capture = clean_capture(FAULHABER, CLEAN)
    return replace(capture, wiring=replace(capture.wiring, **wiring))


def bent(capture: Capture, size: float, shape: Curve) -> Capture:
    """Whose current's sensor leaves its line by so much of full scale."""
    channel = capture.channels[CURRENT]
    raw = channel.raw + size * FULL_A * COURSES[shape](channel.raw / FULL_A)
    return replace(capture, channels={**capture.channels, CURRENT: replace(channel, raw=raw)})


def stating(capture: Capture, u: float, shape: Curve) -> Capture:
    """With what a data sheet says of that sensor."""
    channel = replace(
        capture.channels[CURRENT], nonlinearity=u, nonlinearity_shape=shape, full_scale=FULL_A
    )
    return replace(capture, channels={**capture.channels, CURRENT: channel})


def off(found: Estimate) -> dict[str, float]:
    """How many standard uncertainties each parameter is off."""
    parameters = found.parameters
    return {n: (parameters[n].value - FAULHABER[n]) / parameters[n].total for n in PARAMETERS}


@pytest.mark.parametrize(("shape", "degree"), [("bow", 2), ("s", 3)])
def test_a_data_sheet_s_departures_are_chebyshev_s(shape: Curve, degree: int) -> None:
    """Of all such courses the one whose largest departure from a line is least."""
    course = COURSES[shape](SMALL)
    ideal = chebval(SMALL, [0.0] * degree + [1.0])
    zero = ideal[len(SMALL) // 2]  # taken at no current
    assert course == pytest.approx(ideal - zero, abs=1e-12)
    line = np.polynomial.Polynomial.fit(SMALL, course, 1)
    assert np.abs(course - line(SMALL)).max() >= 1.0 - 1e-9


def test_a_cubic_is_right_at_small_currents_and_off_by_its_size_at_full_scale() -> None:
    course = COURSES["cubic"]
    assert course(np.array([-1.0, 1e-3, 1.0])) == pytest.approx([-1.0, 1e-9, 1.0])


def test_its_tangent_is_that_course_of_the_current_and_of_nothing_else() -> None:
    change, shown = moved("measured", CURRENT_NONLINEARITY), usual("measured")
    measured = record("measured").block(CURRENT)
    assert measured is not None
    full = measured.channel.full_scale
    share = shown[CURRENT] / full
    assert change[CURRENT] == pytest.approx(full * (4 * share**3 - 3 * share), rel=1e-9, abs=1e-12)
    assert not any(part.any() for name, part in change.items() if name != CURRENT)


@pytest.mark.slow
def test_a_course_without_a_shape_is_nothing() -> None:
    """A foreign file that holds a size alone."""
    whole = stating(run(), 0.01, "s")
    channel = whole.channels[CURRENT]
    for known, there in (
        (channel, True),
        (replace(channel, nonlinearity_shape=None), False),
        (replace(channel, full_scale=0.0), False),
        (replace(channel, nonlinearity=0.0), False),
    ):
        capture = replace(whole, channels={**whole.channels, CURRENT: known})
        prior = CURRENT_NONLINEARITY.prior(MotorRecord(capture, PARAMETERS, {}), 0)
        assert (prior is not None) == there


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["bow", "s", "cubic"])
def test_a_bent_sensor_s_figure_makes_the_intervals_hold(shape: Curve) -> None:
    """Without it some parameter is many standard uncertainties off; the line says why with it."""
    size = 0.004
    shown = noisy(bent(run(), size, shape), 1, 2e-3, 1e-4)
    assert max(map(abs, off(fit([shown])).values())) > 3.0
    found = fit([stating(shown, size, shape)])
    assert max(map(abs, off(found).values())) < 2.5
    assert found.budget["R"][CURRENT_NONLINEARITY.name] > 0.0


def test_a_drift_moves_readings_by_the_share_that_has_set_in() -> None:
    change, shown = moved("measured", REFERENCE_DRIFT), usual("measured")
    subject = record("measured")
    wiring, last = subject.capture.wiring, -1
    set_in = 1.0 - np.exp(-ticks("measured", EMF) * 1e-4 / wiring.reference_time_s)
    assert set_in[last] > 0.3
    coasting = within("measured", EMF, len(subject.timeline.parts) - 1)
    late = np.flatnonzero(coasting)[last]
    slower = usual("measured")[EMF][late] * set_in[late]
    # an open bridge reads its back-EMF larger, and the motor began its coast slower
    assert change[EMF][late] < slower
    drive = within("measured", CURRENT, 2)
    assert np.abs(change[CURRENT][drive]).max() < 2.0 * np.abs(shown[CURRENT]).max()
    assert change[POSITION][last] < 0.0  # there was less behind the volts that were read


def test_a_sensor_that_follows_the_reference_does_not_drift() -> None:
    """The motor itself still gets less than was read."""
    channel = replace(run().channels[CURRENT], ratiometric=True)
    plain = run(reference_drift=1e-3, reference_time_s=0.05)
    follows = replace(plain, channels={**plain.channels, CURRENT: channel})
    one = Instance(REFERENCE_DRIFT)
    changes = []
    for capture in (plain, follows):
        subject = MotorRecord(capture, PARAMETERS, {})
        subject.retake_sources(POINT, start(subject))
        own = start(subject)
        block = [m.block.name for m in subject.measured].index(CURRENT)
        changes.append(tangent(subject, POINT, own, one)[block])
        amperes = subject.fitted(POINT, own)[block]
        set_in = 1.0 - np.exp(-subject.measured[block].keep * 1e-4 / 0.05)
    assert changes[0] - changes[1] == pytest.approx(amperes * set_in, rel=1e-6, abs=1e-9)


@pytest.mark.slow
def test_a_drift_s_figure_makes_the_intervals_hold() -> None:
    """Every reading rises; the volts that drove the motor were as they were before."""
    size, tau = 3e-3, 0.05
    capture = run(reference_drift=size, reference_time_s=tau)
    gain = 1.0 + size * -np.expm1(-capture.time_s / tau)
    channels = {
        name: replace(c, raw=gain * c.raw) if name in (CURRENT, VOLTAGE) else c
        for name, c in capture.channels.items()
    }
    shown = noisy(replace(capture, channels=channels), 1, 5e-4, 1e-4)
    silent = replace(shown, wiring=run().wiring)
    assert max(map(abs, off(fit([silent])).values())) > 4.0
    found = fit([shown])
    assert max(map(abs, off(found).values())) < 2.5
    assert found.budget["K"][REFERENCE_DRIFT.name] > 0.0


def eccentric(capture: Capture, size: float, phase: float) -> Capture:
    channel = capture.channels[POSITION]
    raw = channel.raw + size * np.sin(channel.raw + phase)
    return replace(capture, channels={**capture.channels, POSITION: replace(channel, raw=raw)})


def test_an_eccentric_disc_errs_once_in_a_turn_of_its_own_shaft() -> None:
    plain = run(encoder_eccentricity_rad=1e-3)
    wiring = replace(plain.wiring, gear_ratio=4.0)
    turned = replace(plain.channels[POSITION], raw=plain.channels[POSITION].raw / 4.0)
    geared = replace(plain, wiring=wiring, channels={**plain.channels, POSITION: turned})
    for capture, gear in ((plain, 1.0), (geared, 4.0)):
        subject = MotorRecord(capture, PARAMETERS, {})
        sizes = [u for u in subject.unknowns if u.name.startswith("encoder eccentricity")]
        assert [u.prior_sd for u in sizes] == pytest.approx([1e-3 / 2**0.5] * 2)
        own = start(subject)
        block = [m.block.name for m in subject.measured].index(POSITION)
        shown = subject.measured[block].values / gear
        for name, wave in (("0", np.cos), ("1", np.sin)):
            there = [u.name for u in subject.unknowns].index(f"encoder eccentricity {name}")
            more = own.copy()
            more[there] = 1e-3
            change = subject.fitted(POINT, more)[block] - subject.fitted(POINT, own)[block]
            assert change == pytest.approx(1e-3 * gear * wave(shown), abs=1e-9)


@pytest.mark.slow
def test_an_eccentric_disc_is_measured_by_the_fit() -> None:
    size, phase = 4e-3, 0.7
    shown = noisy(eccentric(run(encoder_eccentricity_rad=size), size, phase), 1, 5e-4, 1e-4)
    found = fit([shown])
    cosine, sine = (found.nuisance[f"{ENCODER_ECCENTRICITY.name} {k}"] for k in (0, 1))
    assert cosine.value == pytest.approx(size * np.sin(phase), abs=3.0 * cosine.total)
    assert sine.value == pytest.approx(size * np.cos(phase), abs=3.0 * sine.total)
    assert max(map(abs, off(found).values())) < 3.0
    assert all(ENCODER_ECCENTRICITY.name in lines for lines in found.budget.values())


def test_wide_codes_move_what_lies_beyond_them_by_one_step_each() -> None:
    channel = Channel(
        VOLTAGE, "V", np.zeros(1), scale=0.5, offset=100.0, raw_min=-60.0, raw_max=260.0,
        step_uncertainty=0.03,
    )  # fmt: skip
    volts = np.array([0.0, 19.0, 21.0, 59.0, 61.0, -19.0, -21.0, -61.0])  # of 80 V to each side
    shown = steps(channel, volts)
    assert shown == pytest.approx(0.03 * np.array([0, 0, 1, 1, 2, 0, -1, -2]))
    assert steps(channel, np.array([20.0])) == pytest.approx(0.015)  # amid the wide code
    for unstated in ({"step_uncertainty": 0.0}, {"raw_max": np.inf}):
        assert not steps(replace(channel, **unstated), volts).any()


def test_a_converter_s_steps_move_current_and_source_alike() -> None:
    change, subject = moved("stepped", CONVERTER_STEPS), record("stepped")
    volts = replace(subject.capture.channels[VOLTAGE], step_uncertainty=0.0)
    without = replace(subject.capture, channels={**subject.capture.channels, VOLTAGE: volts})
    alone = MotorRecord(without, PARAMETERS, {})
    shown = tangent(alone, POINT, start(alone), Instance(CONVERTER_STEPS))
    for block, base, more in zip(
        alone.measured, alone.fitted(POINT, start(alone)), shown, strict=True
    ):
        own = steps(block.channel, base) if block.block.name == CURRENT else np.zeros_like(base)
        assert own.any() == (block.block.name == CURRENT)
        assert more == pytest.approx(own, abs=1e-9)
    # there was less behind 6 V that were read, so that the motor turned less than it would have
    assert change[POSITION][-1] < 0.0
