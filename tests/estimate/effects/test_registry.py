"""Every influence quantity there is: how it is declared, and its derivative in tiny captures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from motorid.estimate.effects.action import Reading
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Instance,
    Scope,
    Use,
    instances,
)
from motorid.estimate.effects.reading.smoothing import SMOOTHED
from motorid.estimate.effects.registry import BY_NAME, CAPTURED, REGISTRY, SECOND_ORDER
from motorid.estimate.model.capture_model import Floats, MotorRecord
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.model.tangent import tangent
from tests.estimate.effects.benches import BENCHES, POINT, record, start

OTHER_STEP = 3.0  # times the step by which the tangent was taken
NEAR = 1e-3  # of the largest change of a reading
UNSEEN = {"initial warmth", "cogging phase", "ripple phase"}  # by the six-parameter model
BY_SQUARE = {q.name for q in SECOND_ORDER.values()}  # no slope where they are none
BY_OTHERS = {
    "ripple of K", "ripple of R", "cogging torque", "encoder error", "current offset while driven",
    "speed filter", "speed dead band", "missed counts", "supply path", "quadratic friction",
    "friction by direction", "friction ripple", "current coupling",
    "common mode of the current",
    "sag of the reference", "voltage noise", "PWM ripple", "ambient temperature", "self-heating",
    "copper coefficient", "magnets' coefficient",
    *(quantity.name for ways in SMOOTHED.values() for quantity in ways.values()),
}  # fmt: skip


def applying(quantity: InfluenceQuantity) -> Iterator[tuple[MotorRecord, int]]:
    """Every tiny capture that has the quantity, and each of its places there."""
    for name in BENCHES:
        subject = record(name)
        for one in instances(quantity, subject):
            if one.unknown(subject) is not None:
                yield subject, one.place


def by(subject: MotorRecord, quantity: InfluenceQuantity, place: int, size: float) -> list[Floats]:
    """The readings with so much of the quantity."""
    own = start(subject)
    return subject.fitted(POINT, own, {Instance(quantity, place): size})


def test_names_are_unique() -> None:
    assert len(BY_NAME) == len(REGISTRY)
    assert len({name.casefold() for name in BY_NAME}) == len(REGISTRY)


@pytest.mark.parametrize("quantity", REGISTRY, ids=lambda q: q.name)
def test_a_declaration_is_whole(quantity: InfluenceQuantity) -> None:
    for text in (quantity.name, quantity.unit, quantity.remedy):
        assert text
        assert text == text.strip()
    assert quantity.remedy[0].islower()
    assert not quantity.remedy.endswith(".")  # it ends a sentence of the report
    assert 0.0 < quantity.step < 1.0


def test_an_effect_that_was_not_found_is_a_term_of_wider_models() -> None:
    assert {q.term for q in REGISTRY if q.use is Use.UNDETECTED} <= TERMS.keys()
    assert {q.use for q in REGISTRY if q.term} == {Use.UNDETECTED}


@pytest.mark.slow
@pytest.mark.parametrize("quantity", CAPTURED, ids=lambda q: q.name)
def test_some_tiny_capture_has_it(quantity: InfluenceQuantity) -> None:
    """Else the tests of derivatives would say nothing of it."""
    assert list(applying(quantity))


def test_what_no_capture_has_by_itself_is_added_by_others() -> None:
    assert {q.name for q in REGISTRY if not list(applying(q))} == BY_OTHERS


@pytest.mark.parametrize("quantity", REGISTRY, ids=lambda q: q.name)
def test_priors_and_bounds_are_numbers(quantity: InfluenceQuantity) -> None:
    for subject, place in applying(quantity):
        prior = quantity.prior(subject, place)
        assert prior is not None
        lower, upper = quantity.bounds(subject)
        assert not np.isnan([prior.sd, prior.mean, lower, upper]).any()
        assert prior.sd > 0.0
        assert np.isfinite(prior.mean)
        assert lower <= prior.mean <= upper
        if prior.start is not None:
            assert np.isfinite(prior.start)
            assert lower <= prior.start <= upper
        assert 0.0 < quantity.scale(subject) < np.inf


@pytest.mark.parametrize(
    "quantity",
    [q for q in REGISTRY if q.name not in UNSEEN | BY_SQUARE | BY_OTHERS],
    ids=lambda q: q.name,
)
def test_the_tangent_is_the_slope_of_the_readings(quantity: InfluenceQuantity) -> None:
    """At another step than its own, and it is not nothing in every capture."""
    most = 0.0
    for subject, place in applying(quantity):
        slope = np.concatenate(tangent(subject, POINT, start(subject), Instance(quantity, place)))
        step = OTHER_STEP * quantity.step * quantity.scale(subject)
        lower, upper = quantity.bounds(subject)
        low, high = max(-step, lower), min(step, upper)
        before = np.concatenate(by(subject, quantity, place, low))
        after = np.concatenate(by(subject, quantity, place, high))
        largest = float(np.abs(slope).max())
        assert np.abs((after - before) / (high - low) - slope).max() <= NEAR * largest
        most = max(most, largest)
    assert most > 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "quantity",
    [q for q in REGISTRY if q.acts and all(isinstance(a, Reading) for a in q.acts)],
    ids=lambda q: q.name,
)
@pytest.mark.parametrize("size", [-0.7, 1e-6, 3.0])
def test_what_channels_show_is_linear(quantity: InfluenceQuantity, size: float) -> None:
    for subject, place in applying(quantity):
        slope = tangent(subject, POINT, start(subject), Instance(quantity, place))
        usual = subject.fitted(POINT, start(subject))
        for d, y, moved in zip(slope, usual, by(subject, quantity, place, size), strict=True):
            assert moved == pytest.approx(y + size * d, rel=1e-9, abs=1e-9 * np.abs(y).max())


def test_what_a_capture_has_many_of_is_not_listed_one_by_one() -> None:
    """Courses by order, levels, jumps and turns by part say nothing of the motor or its rig.

    The two halves of an eccentric encoder's wave are of the rig.
    """
    many = {q.name for q in REGISTRY if q.places is not None and q.listed}
    assert many == {"encoder eccentricity"}


def test_what_a_capture_has_one_of_is_listed_but_for_shapes_of_another() -> None:
    """The bend of a drop, and what diodes take of a dead time, are parts of what is listed."""
    alone = {q.name for q in REGISTRY if q.places is None and not q.listed}
    assert alone == {"brush bend", "dead-time diodes"}


def test_a_cause_of_the_bench_is_one_for_all_captures() -> None:
    """A gain, a delay and a clock are of the bench; how a run begins is its own."""
    for quantity in REGISTRY:
        name = quantity.name
        if name.endswith(("gain", "delay", "filter")) or name in ("clock", "current offset"):
            assert quantity.scope is Scope.MOTOR, name
        if name.startswith("initial ") or quantity.places is not None:
            assert quantity.scope is not Scope.MOTOR or "ripple" in name or "turn" in name, name
