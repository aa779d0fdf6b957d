"""Profiles of likelihoods that are parabolas, or lean: their roots, their ends, and who has one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.errors import DataError
from motorid.estimate.solver.problem import Solution, Unknown
from motorid.estimate.uncertainty import profile_likelihood
from motorid.estimate.uncertainty.profile_likelihood import Profile, interval, intervals
from tests.estimate.made_findings import RELATIVE, VALUES, findings

BASE = 40.0  # objective of the best


@dataclass
class Parabola:
    """A search whose objective is a parabola in search coordinates, about the solution."""

    solution: Solution
    asked: list[Sequence[Unknown]] = field(default_factory=list)

    def __call__(self, held: Sequence[Unknown], records: Any, before: Solution) -> Any:
        assert before is self.solution
        assert records == ("run",)
        self.asked.append(held)
        (k,) = [k for k, u in enumerate(held) if u.lower == u.upper]
        assert held[k].start == held[k].lower
        best = self.solution.values
        assert [u.start for n, u in enumerate(held) if n != k] == list(np.delete(best, k))
        away = math.log(held[k].start / best[k]) if held[k].log else held[k].start - best[k]
        variance = np.linalg.inv(self.solution.information)[k, k]
        return SimpleNamespace(objective=BASE + away**2 / variance)


def searched(monkeypatch: pytest.MonkeyPatch, **how: Any) -> Parabola:
    solution = replace(findings(**how).solution, objective=BASE)
    search = Parabola(solution)
    monkeypatch.setattr(profile_likelihood, "maximise", search)
    return search


def place(name: str) -> int:
    return list(VALUES).index(name)


def test_the_root_of_the_fall_counts_standard_deviations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also of one that others follow: the fall is with everything else most likely again."""
    search = searched(monkeypatch, correlation={("R", "B"): 0.6})
    friction = Profile(search.solution, ("run",), place("B"))  # type: ignore[arg-type]
    assert friction.best == VALUES["B"]
    sd = RELATIVE["B"] * VALUES["B"]
    assert friction.root(VALUES["B"] - 2.0 * sd) == pytest.approx(2.0)
    resistance = Profile(search.solution, ("run",), place("R"))  # type: ignore[arg-type]
    assert resistance.root(VALUES["R"] * math.exp(3.0 * RELATIVE["R"])) == pytest.approx(3.0)
    kept = search.solution.unknowns
    for asked in search.asked:
        assert [(u.name, u.log, u.scale) for u in asked] == [(u.name, u.log, u.scale) for u in kept]
        assert sum(u.lower == v.lower and u.upper == v.upper for u, v in
                   zip(asked, kept, strict=True)) == len(kept) - 1  # fmt: skip


def test_a_root_is_nothing_where_the_search_came_lower_and_no_end_without_a_motor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    solution = replace(findings().solution, objective=BASE)
    profile = Profile(solution, (), 0)
    better = SimpleNamespace(objective=BASE - 1.0)
    monkeypatch.setattr(profile_likelihood, "maximise", lambda *_, **__: better)
    assert profile.root(2.1) == 0.0

    def fails(*_: Any, **__: Any) -> Any:
        raise DataError("no motor")

    monkeypatch.setattr(profile_likelihood, "maximise", fails)
    assert profile.root(2.1) == math.inf


@dataclass(frozen=True)
class Falling(Profile):
    """A root that grows from the best at 10 by ``rate`` a unit, and by ``bent`` its square."""

    rate: float = 0.5
    bent: float = 0.0
    tried: list[float] = field(default_factory=list)

    @property
    def best(self) -> float:
        return 10.0

    def root(self, value: float) -> float:
        self.tried.append(value)
        away = abs(value - self.best)
        return self.rate * away + self.bent * away**2


def falling(**how: float) -> Falling:
    return Falling(None, (), 0, **how)  # type: ignore[arg-type]


@pytest.mark.parametrize(("first", "end"), [(11.0, 14.0), (13.0, 14.0), (17.0, 14.0), (9.0, 6.0)])
def test_a_parabolas_end_is_found_by_the_second_fit(first: float, end: float) -> None:
    profile = falling()
    assert profile.end(first, 2.0) == pytest.approx(end)
    assert profile.tried == pytest.approx([first, end])


def test_a_first_fit_that_is_near_is_the_end() -> None:
    for first, fits in ((14.1, 1), (13.9, 1), (14.2, 2), (13.8, 2)):  # 2.5 % off, or 5 %
        profile = falling()
        found = profile.end(first, 2.0)
        assert len(profile.tried) == fits
        assert found == pytest.approx(first if fits == 1 else 14.0)


@pytest.mark.parametrize("first", [12.0, 13.0, 20.0, 8.0])
def test_a_root_that_bends_is_followed_in_a_few_fits(first: float) -> None:
    profile = falling(rate=0.4, bent=0.02)
    away = abs(profile.end(first, 2.0) - 10.0)
    assert 0.4 * away + 0.02 * away**2 == pytest.approx(2.0, rel=profile_likelihood.NEAR)
    assert len(profile.tried) <= 4


def test_between_a_fall_too_small_and_one_too_large_the_middle_is_tried() -> None:
    """Where the likelihood drops at once, no proportion leads to its end."""
    profile = falling(rate=0.0)
    object.__setattr__(profile, "root", lambda v: profile.tried.append(v) or float(v > 13.0))
    end = profile.end(12.0, 0.5)
    assert profile.tried == pytest.approx([12.0, 18.0, 14.0, 13.0, 13.5])
    assert end == pytest.approx(13.5)  # the far side


def test_no_end_lies_beyond_four_times_the_parabolas() -> None:
    """Of a likelihood that hardly falls, and of one that does not at all."""
    for rate in (1e-3, 0.0):
        assert falling(rate=rate).end(11.0, 2.0) == pytest.approx(14.0)
        assert falling(rate=rate).end(9.5, 2.0) == pytest.approx(8.0)


def test_an_end_stays_above_the_least_that_there_is() -> None:
    """Of friction 0: fits there and no lower; it is the end where the likelihood has not fallen."""
    shallow = falling(rate=0.1)
    assert shallow.end(5.0, 2.0) == 0.0
    assert min(shallow.tried) == 0.0
    assert falling(rate=0.1).end(5.0, 2.0, least=3.0) == 3.0
    assert falling(rate=0.1).end(1.0, 0.5, least=3.0) == pytest.approx(5.0)
    assert falling(rate=1.0).end(-4.0, 2.0) == pytest.approx(8.0)
    edge = falling(rate=0.2)  # the fall at 0 is what is wanted
    assert edge.end(-3.0, 2.0) == 0.0


def test_an_interval_of_a_logarithm_is_of_factors(monkeypatch: pytest.MonkeyPatch) -> None:
    """A covariance twice as wide as white noise's: the fall is to be twice as deep."""
    search = searched(monkeypatch)
    sd = RELATIVE["L"]
    low, high = interval(search.solution, ("run",), place("L"), 4.0 * sd, sd)  # type: ignore[arg-type]
    assert low == pytest.approx(VALUES["L"] * math.exp(-4.0 * sd), rel=1e-3)
    assert high == pytest.approx(VALUES["L"] * math.exp(4.0 * sd), rel=1e-3)
    assert len(search.asked) == 2  # where the parabola is right


def test_an_interval_of_friction_is_of_differences_down_to_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = searched(monkeypatch)
    value, sd = VALUES["T0"], RELATIVE["T0"] * VALUES["T0"]
    ends = interval(search.solution, ("run",), place("T0"), 3.0 * sd, 1.5 * sd)  # type: ignore[arg-type]
    assert ends == pytest.approx((value - 2.0 * sd, value + 2.0 * sd), rel=2e-3)
    wide = searched(monkeypatch, relative={**RELATIVE, "T0": 0.8})
    sd = 0.8 * value
    ends = interval(wide.solution, ("run",), place("T0"), 2.0 * sd, sd)  # type: ignore[arg-type]
    assert ends == pytest.approx((0.0, value + 2.0 * sd))
    none = searched(monkeypatch, bound=("T0",))
    sd = RELATIVE["T0"] * value
    assert interval(none.solution, ("run",), place("T0"), 2.0 * sd, sd) == pytest.approx(  # type: ignore[arg-type]
        (0.0, 2.0 * sd)
    )
    assert len(none.asked) == 1  # below nothing there is nothing to try


def test_a_hardly_told_inductance_ends_where_four_parabolas_would(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its likelihood falls nowhere: the ends are as far as any may lie."""
    solution = replace(findings().solution, objective=BASE)
    flat = SimpleNamespace(objective=BASE)
    monkeypatch.setattr(profile_likelihood, "maximise", lambda *_, **__: flat)
    low, high = interval(solution, (), place("L"), 0.1, 0.05)
    assert low == pytest.approx(VALUES["L"] * math.exp(-0.4))
    assert high == pytest.approx(VALUES["L"] * (1.0 + 4.0 * (math.exp(0.1) - 1.0)))


def profiled(monkeypatch: pytest.MonkeyPatch, **how: Any) -> dict[str, tuple[Any, ...]]:
    """Reach and white deviation of each that gets an interval."""
    found = findings(**how)

    def given(solution: Any, records: Any, k: int, reach: float, white: float) -> Any:
        assert solution is found.solution
        assert records == ("run",)
        return solution.unknowns[k].name, reach, white

    monkeypatch.setattr(profile_likelihood, "interval", given)
    out: dict[str, Any] = intervals(found.solution, ("run",), found.statistical)  # type: ignore[arg-type]
    assert all(name == said[0] for name, said in out.items())
    return out


@pytest.mark.parametrize(
    ("name", "straight", "leaning"),
    [("B", 0.38, 0.42), ("T0", 0.38, 0.42), ("L", 0.11, 0.13), ("R", 0.4, None), ("J", 0.4, None)],
)
def test_friction_and_inductance_lean_from_a_share_of_themselves_on(
    name: str, straight: float, leaning: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert profiled(monkeypatch, relative={**RELATIVE, name: straight}) == {}
    if leaning is not None:
        assert list(profiled(monkeypatch, relative={**RELATIVE, name: leaning})) == [name]


def test_an_inductance_that_is_not_given_has_no_profile(monkeypatch: pytest.MonkeyPatch) -> None:
    assert list(profiled(monkeypatch, relative={**RELATIVE, "L": 0.49})) == ["L"]
    assert profiled(monkeypatch, relative={**RELATIVE, "L": 0.51}) == {}
    assert list(profiled(monkeypatch, relative={**RELATIVE, "B": 5.0})) == ["B"]


def test_where_a_parameter_is_at_its_bound_all_friction_leans(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert list(profiled(monkeypatch, bound=("B",))) == ["B", "T0"]


def test_friction_without_a_scale_of_torque_has_no_profile(monkeypatch: pytest.MonkeyPatch) -> None:
    vague = {**RELATIVE, "B": 0.6, "L": 0.2}
    assert list(profiled(monkeypatch, relative=vague)) == ["L", "B"]
    assert list(profiled(monkeypatch, relative={**vague, "K": 0.6})) == ["L"]


def test_the_reach_is_students_of_the_covariance_and_white_noise_is_beside_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    how = {"relative": {**RELATIVE, "L": 0.2, "B": 0.5}, "freedom": 4.0}
    found = profiled(monkeypatch, **how)
    assert found["L"] == ("L", pytest.approx(2.77645 * 0.2), pytest.approx(0.2))
    sd = 0.5 * VALUES["B"]
    assert found["B"] == ("B", pytest.approx(2.77645 * sd), pytest.approx(sd))
