"""More unknowns along straight lines: against a least squares with all unknowns at once."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.rotor.k_ripple import K_RIPPLE
from motorid.estimate.effects.rotor.repeating import of_order
from motorid.estimate.fit import repeating, straight_lines
from motorid.estimate.fit.straight_lines import StraightLines, fall
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.solver.problem import Block, Linearised, Unknown

COSINE, SINE = of_order(K_RIPPLE, 7)
SIGMAS = np.repeat([0.5, 2.0], [40, 60])
PRIORS: dict[Instance, float | None] = {COSINE: 0.4, SINE: None}


@pytest.fixture(autouse=True)
def _priors(monkeypatch: pytest.MonkeyPatch) -> None:
    """The cosine has a prior; nothing is known of the sine."""

    def unknown(one: Instance, _: Any) -> Unknown | None:
        sd = PRIORS[one]
        return None if sd is None else Unknown(one.name, 0.0, prior_sd=sd)

    monkeypatch.setattr(Instance, "unknown", unknown)


def system() -> tuple[StraightLines, Any, np.ndarray, np.ndarray]:
    """A record of two channels, courses of two unknowns more, the design of all others, and the
    readings' part of the residual.
    """
    rng = np.random.default_rng(11)
    own, shared = rng.standard_normal((100, 1)), rng.standard_normal((100, 2))
    orthogonal = shared - own @ np.linalg.inv(own.T @ own) @ own.T @ shared
    design = np.column_stack([shared, own])
    courses = {
        COSINE: {"current": rng.standard_normal(40), "speed": rng.standard_normal(60)},
        SINE: {"speed": rng.standard_normal(60)},
    }
    residual = rng.standard_normal(100) + 0.3 * np.r_[np.zeros(40), courses[SINE]["speed"]]
    residual -= design @ np.linalg.lstsq(design, residual, rcond=None)[0]
    line = Linearised(
        residual, shared, own, orthogonal, np.zeros(1),
        (Block("current", 0.1, 40.0), Block("speed", 0.1, 60.0)),
        (slice(0, 40), slice(40, 100)), np.array([0.5, 2.0]),
    )  # fmt: skip
    measured = [
        SimpleNamespace(block=SimpleNamespace(name=name), values=np.zeros(n))
        for name, n in (("current", 40), ("speed", 60))
    ]
    record: Any = SimpleNamespace(measured=measured, weighed=lambda parts: [2.0 * p for p in parts])
    lines = StraightLines(record, line, np.linalg.inv(shared.T @ orthogonal))
    return lines, courses, design, residual


def weighed(courses: dict[str, np.ndarray]) -> np.ndarray:
    """A change of the readings in standard deviations; each reading counts for four."""
    return 2.0 * np.r_[courses.get("current", np.zeros(40)), courses["speed"]] / SIGMAS


def test_sizes_are_those_of_a_fit_with_them_among_the_unknowns() -> None:
    lines, courses, design, residual = system()
    more = np.column_stack([weighed(courses[one]) for one in (COSINE, SINE)])
    every = np.column_stack([design, more])
    prior = np.diag([0.0, 0.0, 0.0, 0.4**-2, 0.0])
    found = np.linalg.solve(every.T @ every + prior, every.T @ residual)
    sizes, left = lines.fitted(courses)
    assert sizes == pytest.approx(found[3:])
    assert left == pytest.approx(residual - every @ found)
    none, same = lines.fitted({})
    assert none.shape == (0,)
    assert same == pytest.approx(residual)


def test_rows_are_changes_as_the_likelihood_counts_them() -> None:
    lines, courses, *_ = system()
    rows = lines.rows(courses)
    assert rows[0] == pytest.approx(weighed(courses[COSINE]) * SIGMAS)
    assert rows[1] == pytest.approx(weighed(courses[SINE]) * SIGMAS)
    assert not rows[1][:40].any()
    assert lines.rows({}).shape == (0, 100)


def test_a_length_is_what_no_other_unknown_explains() -> None:
    lines, courses, design, _ = system()
    row = weighed(courses[COSINE])
    rest = row - design @ np.linalg.lstsq(design, row, rcond=None)[0]
    assert lines.length(courses[COSINE]) == pytest.approx(np.linalg.norm(rest))


def test_a_shift_is_the_parameter_that_moves_most_in_its_deviations() -> None:
    lines, courses, design, _ = system()
    for one in (COSINE, SINE):
        row = weighed(courses[one])
        moved = np.linalg.lstsq(design, row, rcond=None)[0][:2]
        deviations = np.sqrt(np.diag(np.linalg.inv(design.T @ design)))[:2]
        assert lines.shift(courses[one]) == pytest.approx(np.max(np.abs(moved) / deviations))
        turned = {name: -course for name, course in courses[one].items()}
        assert lines.shift(turned) == pytest.approx(lines.shift(courses[one]))


def test_a_fall_counts_what_is_looked_at_by_its_worth(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of blocks worth 40 and 60 readings: a quarter of the one, whose colour makes three of its
    readings one; all of the other, of which nothing is left.
    """
    colours = {10: 3.0, 60: 1.0}
    monkeypatch.setattr(straight_lines, "prominence", lambda left: colours[len(left)])
    lines, *_ = system()
    before, after = np.full(100, 2.0), np.full(100, 0.5)
    after[40:] = 0.0
    shows: Any = [lambda residual: residual[5:15], lambda residual: residual]
    fallen, readings = fall(lines.line, before, after, shows)
    worth = 40.0 * 0.25 / 3.0
    assert readings == pytest.approx(worth + 60.0)
    nothing = np.log(60.0 * 4.0 / 1e-300)
    assert fallen == pytest.approx(worth * np.log(16.0) + 60.0 * nothing)
    rising, _ = fall(lines.line, np.full(100, 0.5), np.full(100, 2.0), shows)
    assert rising == pytest.approx(-(worth + 60.0) * np.log(16.0))


# what repeats: a record about a solution


class Response:
    """What a run shows of orders, computed by nobody."""

    def __init__(self, *_: Any) -> None:
        self.angle = np.linspace(0.0, 6.0 * np.pi, 100)
        self.given: Any = None

    def bends(self, slopes: Any, sizes: Any) -> Any:
        self.given = dict(slopes), dict(sizes)
        return {"speed": np.full(60, 0.25)}

    def course(self, sizes: Any) -> Any:
        return dict(sizes)


def turning(monkeypatch: pytest.MonkeyPatch) -> tuple[Any, Any]:
    monkeypatch.setattr(repeating, "RepeatingResponse", Response)
    lines, courses, *_ = system()
    record = lines.record
    for m, keep in zip(record.measured, (np.arange(40), np.arange(40, 100)), strict=True):
        m.keep = keep
    record.departures = lambda shared, own: [shared[0] * np.ones(40), own[0] * np.ones(60)]  # type: ignore[method-assign]
    inverse = lines._inverse
    one = repeating._Turning(record, np.array([3.0]), np.array([5.0]), lines.line, inverse)
    return one, courses


def test_a_rotors_turns_are_from_one_end_of_its_motion_to_the_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one, _ = turning(monkeypatch)
    assert one.turns == pytest.approx(3.0)
    assert one.left is one.lines.line.residual
    assert one.slopes == {}
    assert len(one.sizes) == 0


def test_what_was_taken_is_fitted_together_and_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    one, courses = turning(monkeypatch)
    for known in courses:
        one.take({known: courses[known]})
    sizes, left = one.lines.fitted(courses)
    assert list(one.slopes) == [COSINE, SINE]
    assert one.sizes == pytest.approx(sizes)
    assert one.left == pytest.approx(left)
    shown = one._shown(courses)
    assert shown["current"] == pytest.approx(sizes[0] * courses[COSINE]["current"])
    both = sizes[0] * courses[COSINE]["speed"] + sizes[1] * courses[SINE]["speed"]
    assert shown["speed"] == pytest.approx(both)
    assert set(one._shown({SINE: courses[SINE]})) == {"speed"}
    assert one.course() == pytest.approx(dict(zip(courses, sizes, strict=True)))


def test_counts_are_of_what_is_left_of_the_readings(monkeypatch: pytest.MonkeyPatch) -> None:
    one, courses = turning(monkeypatch)
    one.take(courses)
    shown = one._shown(courses)
    asked: list[Any] = []
    monkeypatch.setattr(repeating, "turned", lambda *of: asked.append(of) or "turned")
    assert one.counted() == "turned"
    ((record, left, angle),) = asked
    assert record is one.record
    assert left[0] == pytest.approx(3.0 - shown["current"])
    assert left[1] == pytest.approx(5.0 - shown["speed"])
    assert angle is one.response.angle


def test_each_channel_is_looked_at_along_its_own_angle(monkeypatch: pytest.MonkeyPatch) -> None:
    one, _ = turning(monkeypatch)
    monkeypatch.setattr(
        repeating, "recurring", lambda left, keep, angle, period: (left, keep, angle, period)
    )
    current, speed = one.sights(2.5, coasts=True)
    angle, (first, second) = one.response.angle, (m.keep for m in one.record.measured)
    assert current("a") == ("a", first, angle, 2.5)
    assert speed("b") == ("b", second, angle, 2.5)
    one.record.measured[1].block = SimpleNamespace(name=EMF)
    current, emf = one.sights(2.5, coasts=False)
    assert current("a") == ("a", first, angle, 2.5)
    assert len(emf(np.ones(60))) == 0


@pytest.mark.parametrize(("share", "bends"), [(0.29, True), (0.31, False)])
def test_a_bend_must_be_small_beside_the_straight_line(
    share: float, bends: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the motor: an encoder's error bends nothing."""
    one, courses = turning(monkeypatch)
    one.take(courses)
    encoder = one._shown({SINE: courses[SINE]})
    monkeypatch.setattr(repeating, "is_of_motor", lambda known: known is SINE)

    def length(of: Any) -> float:
        if np.allclose(of["speed"], 0.25):
            return 10.0 * share
        assert of["speed"] == pytest.approx(encoder["speed"])
        return 10.0

    monkeypatch.setattr(one.lines, "length", length)
    found = one.bend()
    assert (found is not None) is bends
    assert one.response.given == (one.slopes, one._sized)


def test_courses_anew_are_of_the_same_quantities_and_sizes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Along another motion: those of the motor change, an encoder's error stays."""
    other = Instance(K_RIPPLE, 99)
    record: Any = SimpleNamespace(
        repeating=SimpleNamespace(slopes={COSINE: "old", SINE: "old", other: "old"})
    )
    asked: list[int] = []

    class Anew(Response):
        def slopes(self, periods: int) -> Any:
            asked.append(periods)
            return {COSINE: "new", SINE: "new", Instance(K_RIPPLE, 55): "new"}

    monkeypatch.setattr(repeating, "is_of_motor", lambda one: one is not other)
    response, sizes = Anew(), {COSINE: 1.0, SINE: 2.0, other: 3.0, Instance(K_RIPPLE, 2): 4.0}
    found = repeating._anew(record, sizes, response)  # type: ignore[arg-type]
    assert asked == [7]
    assert found.slopes == {COSINE: "new", SINE: "new", other: "old"}
    assert response.given == (found.slopes, sizes)
    assert found.course == {COSINE: 1.0, SINE: 2.0, other: 3.0}


# which orders


def rotor() -> Any:
    """Of many turns; nobody says what its encoder shows."""
    return SimpleNamespace(
        turns=9.0, counted=list, record=SimpleNamespace(gear=1.0),
        response=SimpleNamespace(encoder_error=lambda n: {}),
    )  # fmt: skip


def trial(monkeypatch: pytest.MonkeyPatch, gains: list[float]) -> list[float]:
    """Gains of an encoder's orders that are taken."""
    left, taken = list(gains), list[float]()
    monkeypatch.setattr(repeating, "periods_a_turn", lambda *_: [])
    monkeypatch.setattr(
        repeating, "_trial", lambda _found, slopes, _turn: repeating._Trial(slopes, left.pop(0))
    )
    monkeypatch.setattr(repeating, "_taken", lambda _, one: taken.append(one.gain))
    repeating._take([rotor()])
    return taken


def test_an_order_that_gains_nothing_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    assert trial(monkeypatch, [0.0, 0.0]) == []
    assert trial(monkeypatch, [1e-9, 0.0]) == [1e-9]
    assert trial(monkeypatch, [-1.0, 2.0]) == [2.0]


@pytest.mark.parametrize(("gain", "taken"), [(0.0, 0), (1e-9, 4)])
def test_an_order_of_the_motor_that_gains_nothing_ends_the_search(
    gain: float, taken: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Four are taken at most, each of another count."""
    counts, orders = iter(range(10, 20)), list[Any]()
    monkeypatch.setattr(repeating, "periods_a_turn", lambda *_: [next(counts)])
    monkeypatch.setattr(
        repeating, "_either",
        lambda _, n: repeating._Trial([{Instance(K_RIPPLE, 2 * n): {}}], gain),
    )  # fmt: skip
    monkeypatch.setattr(repeating, "_trial", lambda *_: repeating._Trial([], -1.0))
    monkeypatch.setattr(repeating, "_taken", lambda _, one: orders.extend(one.slopes[0]))
    repeating._take([rotor()])
    assert len(orders) == taken


def test_several_records_gain_together_less_one_margin(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each unknown of each costs the logarithm of all readings' worth."""
    falls = [(30.0, 50.0), (40.0, 70.0)]
    left = list(falls)
    monkeypatch.setattr(repeating, "fall", lambda *_: left.pop(0))
    one: Any = SimpleNamespace(
        slopes={}, left=None, sights=lambda period, _: [],
        lines=SimpleNamespace(fitted=lambda _: (None, None), line=None),
    )  # fmt: skip
    slopes: Any = [{COSINE: {}, SINE: {}}, {COSINE: {}}]
    found = repeating._trial([one, one], slopes, 1.0)
    assert found.gain == pytest.approx(70.0 - repeating.MARGIN - 3.0 * np.log(120.0))
    assert found.slopes is slopes
    left = [(30.0, 0.5), (0.0, 0.5)]
    few = repeating._trial([one, one], slopes, 1.0)
    assert few.gain == pytest.approx(30.0 - repeating.MARGIN - 3.0 * np.log(2.0))


def test_derivatives_that_a_search_knows_go_on_with_those_of_what_was_taken() -> None:
    from motorid.estimate.solver.problem import Derivatives

    known = Derivatives(np.zeros(2), (np.array([9.0]),), ("shared",), (np.ones((1, 3)),))  # type: ignore[arg-type]
    one: Any = SimpleNamespace(
        sizes=np.array([0.5, 0.7]), slopes="slopes",
        lines=SimpleNamespace(rows=lambda of: np.full((2, 3), 4.0) if of == "slopes" else None),
    )  # fmt: skip
    lent = repeating._lent(known, [one])
    assert lent is not None
    assert lent.own[0].tolist() == [9.0, 0.5, 0.7]
    assert lent.own_slopes[0].tolist() == [[1.0] * 3, [4.0] * 3, [4.0] * 3]
    assert lent.shared == ("shared",)
    assert repeating._lent(None, [one]) is None
