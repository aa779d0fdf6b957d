"""A capture under a wider model: its limit of no terms, and what follows the rotor's angle."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from motorid.capture.model import POSITION
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.missed_counts import MISSED_COUNTS
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_capture_model import WideRecord
from motorid.estimate.model.extended_terms import ADDED, NAMES, TERMS, Scales
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.solver.problem import Unknown
from motorid.motor.wide import NAMES as FIELDS
from tests.estimate.effects.benches import POINT, record, start

SIZES = Scales(
    volts=6.0, current=1.0, speed=300.0, torque=0.01, resistance=4.0, inertia=1e-6,
    inductance=2e-4, duration=0.04,
)  # fmt: skip


@cache
def encoder() -> MotorRecord:
    """Of fine steps."""
    capture = record("measured").capture
    position = replace(capture.channels[POSITION], resolution=1e-4)
    channels = {**capture.channels, POSITION: position}
    found = MotorRecord(replace(capture, channels=channels), PARAMETERS, {})
    found.retake_sources(POINT, start(found))
    return found


@cache
def wide(*terms: str, bench: str = "measured") -> WideRecord:
    """The terms' parameters are free; those that are counted are 7 a turn."""
    chosen = [TERMS[name] for name in terms]
    free = (*PARAMETERS, *(name for term in chosen for name in term.free))
    counted = {term.per_turn: 7.0 for term in chosen if term.per_turn}
    return WideRecord(
        encoder() if bench == "measured" else record(bench),
        free,
        counted,
        chosen,
        SIZES,
        {},
        first=True,
    )


def names(one: WideRecord) -> list[str]:
    """Of the shared unknowns, in their order."""
    return [NAMES[place] for place in one._places]


def shared(one: WideRecord, **sizes: float) -> np.ndarray:
    """The six at POINT; the others as stated, else absent."""
    six = dict(zip(PARAMETERS, POINT, strict=True))
    return np.array([
        six[name] if name in six else sizes.get(name, ADDED[name].absent) for name in names(one)
    ])  # fmt: skip


def planned(one: WideRecord) -> list[np.ndarray]:
    """The readings of the six at POINT, with steps that suit them."""
    own = np.array([u.start for u in one.unknowns])
    one.plan(shared(one), own)
    return one.fitted(shared(one), own)


def test_terms_of_no_size_leave_the_motor_of_six_parameters() -> None:
    narrow = encoder()
    for terms in ((), ("direction",), ("cogging",)):
        found = planned(wide(*terms))
        for a, b in zip(found, narrow.fitted(POINT, start(narrow)), strict=True):
            assert a == pytest.approx(b, abs=2e-5 * np.abs(b).max())


@pytest.mark.parametrize(
    ("terms", "followed"),
    [
        (("cogging",), True), (("direction",), False), (("cogging", "direction"), True),
        (("direction", "ripple"), True), (("direction", "quadratic-load"), False),
    ],
)  # fmt: skip
def test_what_repeats_with_the_rotor_follows_its_measured_angle(
    terms: tuple[str, ...], followed: bool
) -> None:
    one = wide(*terms)
    planned(one)
    assert (one._rotor is not None) is followed
    if one._rotor is not None:
        assert one._rotor.shape == (one.timeline.count,)
        measured = one.block(POSITION)
        assert measured is not None
        off = one._rotor[measured.keep] - measured.values
        assert np.ptp(off) < 0.05  # rad: it is the encoder's angle, but for an origin and a delay


def test_without_a_position_the_angle_is_the_models() -> None:
    one = wide("cogging", bench="moving")
    fitted = planned(one)
    assert one._rotor is None
    own = np.array([u.start for u in one.unknowns])
    angle = one.angle(shared(one), own)
    (shown,) = [k for k, m in enumerate(one.measured) if m.block.name == "speed"]
    keep = one.measured[shown].keep
    speed = np.gradient(angle, one.timeline.period_s)[keep]
    assert np.abs(speed - fitted[shown])[20:-20].max() < 0.03 * np.abs(speed).max()


def fields(one: WideRecord, **values: float) -> dict[str, float]:
    """Of the motor that its response takes, by name."""
    return dict(zip(FIELDS, one.motor(shared(one, **values)).tolist(), strict=True))


def test_two_masses_share_the_inertia_and_heat_is_in_units_of_the_copper() -> None:
    one = wide("two-masses", "heating")
    values = fields(one, J2_share=0.25, per_C_w=0.5)
    six = dict(zip(PARAMETERS, POINT, strict=True))
    assert values["J"] == pytest.approx(0.75 * six["J"])
    assert values["load_inertia"] == pytest.approx(0.25 * six["J"])
    assert values["warming"] == pytest.approx(0.5 * 0.00393 * six["R"], rel=0.02)


def test_friction_changes_over_the_longest_capture_and_at_no_rate_by_a_straight_line() -> None:
    one = wide("friction-drift")
    bent = fields(one, T_f=1e-4, r_f=50.0)
    assert (bent["drift"], bent["drift_rate"], bent["drift_span"]) == (1e-4, 50.0, SIZES.duration)
    straight = fields(one, T_f=1e-4, r_f=0.0)
    assert 0.0 < straight["drift_rate"] * SIZES.duration < 1e-5
    assert fields(one, T_f=0.0, r_f=50.0)["drift_span"] == 0.0


def test_an_open_bridge_shows_the_constant_of_the_back_emf() -> None:
    one = wide("ke-kt")
    six = dict(zip(PARAMETERS, POINT, strict=True))
    assert one.emf_constant(shared(one, d_Ke=0.1)) == pytest.approx(1.1 * six["K"])
    assert one.emf_constant(shared(one)) == pytest.approx(six["K"])


def own_of(one: WideRecord, **starts: float) -> np.ndarray:
    return np.array([starts.get(u.name.replace(" ", "_"), u.start) for u in one.unknowns])


@pytest.mark.parametrize("phase", [0.0, 1.0])
def test_an_open_bridge_shows_the_ripple_of_k_by_the_measured_angle(phase: float) -> None:
    """K ω (1 + k cos(7 angle + phase)), a mean over the sample period."""
    one = wide("ripple")
    planned(one)
    own = own_of(one, ripple_phase=phase)
    steady = one.readings(shared(one), own)
    plain, with_it = (one.shown(steady, shared(one, k_K=k), own) for k in (0.0, 0.05))
    m = one.block(EMF)
    assert m is not None
    assert one._rotor is not None
    middle = np.interp(m.keep - 0.5, np.arange(len(one._rotor)), one._rotor)
    expected = 0.05 * plain[EMF] * np.cos(7.0 * middle + phase)
    off = with_it[EMF] - plain[EMF] - expected
    assert np.abs(expected).max() > 0.05
    assert np.abs(off).max() < 0.1 * np.abs(expected).max()
    for name in set(plain) - {EMF}:
        assert (plain[name] == with_it[name]).all()


def test_without_a_measured_angle_an_open_bridge_shows_no_ripple() -> None:
    one = wide("ripple")
    planned(one)
    rotor, one._rotor = one._rotor, None
    try:
        readings = one.readings(shared(one), own_of(one))
        plain, with_it = (one.shown(readings, shared(one, k_K=k), own_of(one)) for k in (0, 0.05))
    finally:
        one._rotor = rotor
    assert (plain[EMF] == with_it[EMF]).all()


def again() -> WideRecord:
    """Another record of the same capture, of its own."""
    return WideRecord(
        encoder(), (*PARAMETERS, "T_c"), {"N_c": 7.0}, [TERMS["cogging"]], SIZES, {}, first=False
    )


def test_a_record_follows_anothers_steps_angle_and_view_of_noise() -> None:
    one, other = again(), again()
    own = np.array([u.start for u in other.unknowns])
    other.plan(shared(other), own)
    filters = [np.array([1.0, -0.5]), *[None] * (len(other.measured) - 1)]
    roots = [None, np.full(len(other.measured[1].values), 0.5), *[None] * (len(filters) - 2)]
    other.whiten(filters)
    other.thin(roots)
    before = one.fitted(shared(one), own)
    one.follow(other)
    assert (one._steps is other._steps, one._rotor is other._rotor) == (True, True)
    assert one._steps is not None
    assert (one.filters, one.thinned) == (other.filters, other.thinned)
    assert one.blocks == other.blocks
    after = one.fitted(shared(one), own)
    for a, b, c in zip(after, other.fitted(shared(one), own), before, strict=True):
        assert (a == b).all()
        assert a == pytest.approx(c, abs=1e-3 * np.abs(c).max())
    assert one.simulated == 2  # what was remembered is of other steps
    steps = one._steps
    one.step_as(encoder())  # of six parameters: it has none
    assert one._steps is steps


def test_nuisances_begin_where_they_are_told_and_know_what_the_six_know() -> None:
    one = again()
    names = {u.name for u in one.unknowns}
    assert "cogging phase" in names
    assert {u.name for u in encoder().unknowns} <= names
    one.starting({"cogging phase": 0.7, "nobody": 1.0})
    assert {u.name: u.start for u in one.unknowns}["cogging phase"] == 0.7
    priors = {u.name: (u.prior_mean, u.prior_sd) for u in one.unknowns}
    for u in encoder().unknowns:
        assert priors[u.name] == (u.prior_mean, u.prior_sd)


@pytest.mark.parametrize("first", [True, False])
def test_a_rise_of_temperature_is_over_that_of_the_first_capture(first: bool) -> None:
    one = WideRecord(
        encoder(), (*PARAMETERS, "per_C_w", "k_w"), {}, [TERMS["heating"]], SIZES, {}, first
    )
    assert ("initial warmth" in {u.name for u in one.unknowns}) is not first
    assert one.modelled == {"heating"}


def test_sources_are_judged_and_steps_are_planned_for_them() -> None:
    """By the values and with the mixer that are given, once each."""
    one, seen = again(), []
    own = np.array([u.start for u in one.unknowns])
    driving, steps = one.driving, one._steps
    one.plan = lambda *of: seen.append(of)  # type: ignore[method-assign,assignment]
    one.retake_sources(shared(one), own)
    assert one.driving is not driving
    assert one.judged_at is not None
    assert one.judged_at[: len(PARAMETERS)] == pytest.approx(POINT)
    assert steps is one._steps
    ((values, sizes),) = seen
    assert values == pytest.approx(shared(one))
    assert sizes is own


def test_a_fault_that_was_found_is_an_unknown_of_wider_models_too() -> None:
    """No capture says anything of it: its own prior is none."""
    six, one = record("measured").twin(), Instance(MISSED_COUNTS, 500)
    six.find({one: Unknown(MISSED_COUNTS.name, 0.004, 0.0, 0.5, prior_sd=0.004)})
    wider = WideRecord(six, PARAMETERS, {}, [], SIZES, {}, first=True)
    assert wider.instances == six.instances
    assert wider.unknowns[-1].prior_sd == 0.004
    assert one in wider.found
