"""Terms as straight lines of records: what a probe changes, what lines and their score say."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.model.extended_terms import ADDED, TERMS
from motorid.estimate.selection import joint_start, predicted_gain, score_derivatives, score_test
from motorid.estimate.selection.score_derivatives import TRIED, Probe
from motorid.estimate.selection.score_test import Candidate, Sums, Tried, begins
from motorid.estimate.selection.trigger import carry_loss
from motorid.estimate.solver.problem import Block, Derivatives, Linearised, Unknown
from tests.estimate.selection.noted_stages import noting
from tests.estimate.solutions import solution

DIRECTION, LOAD, COGS, RIPPLE = (
    TERMS[name] for name in ("direction", "quadratic-load", "cogging", "ripple")
)

# a probe


def probe(**facts: Any) -> Any:
    """Of two records whose readings are sums of what is known of each."""
    made = object.__new__(Probe)
    scales = {"d_T0": 2.0, "T_c": 0.5, "k_K": 0.1, "k_R": 0.2, "i_b": 3.0, "i_K": 7.0}
    values = dict.fromkeys(ADDED, 0.0) | {"R": 2.0, "d_T0": 0.25}

    def fitted(k: int, shared: Any, own: Any) -> Any:
        known = {**values, **shared}
        turned = np.exp(1j * own.get("cogging phase", own.get("ripple phase", 0.0))).real
        size = known["d_T0"] + turned * (known["T_c"] + 3.0 * known["k_K"] + 7.0 * known["k_R"])
        return [np.array([size, 2.0 * size]) * (k + 1.0), np.array([known["w_s"] * size])]

    vars(made).update(
        scales=SimpleNamespace(of=scales.__getitem__), _values=values, _fitted=fitted,
        _base=[fitted(k, {}, {}) for k in (0, 1)], names=("R",),
        records=[SimpleNamespace(weighed=weighed)] * 2, **facts,
    )  # fmt: skip
    return made


def weighed(parts: Any, filtered: bool = True) -> Any:
    assert not filtered
    return [10.0 * part for part in parts]


def test_a_change_is_for_a_unit_of_the_terms_scale_from_what_is_there() -> None:
    """Whatever shape is tried, as the record weighs it before any filter."""
    found = probe().changes(1, DIRECTION, {"w_s": 0.0})
    assert found == pytest.approx(np.array([[40.0, 80.0, 0.0]]))
    (shaped,) = probe().changes(0, DIRECTION, {"w_s": 5.0})
    assert shaped[:2] == pytest.approx([20.0, 40.0])
    assert shaped[2] == pytest.approx(10.0 * 5.0 * (0.25 + 2.0 * TRIED) / TRIED)


def test_what_repeats_changes_by_each_size_and_quarter_of_its_phase() -> None:
    cogs = probe().changes(0, COGS, {})
    assert cogs[:, 0] == pytest.approx([10.0 * 0.5, 0.0], abs=1e-9)
    ripple = probe().changes(0, RIPPLE, {})
    first = [10.0 * 3.0 * 0.1, 0.0, 10.0 * 7.0 * 0.2, 0.0]
    assert ripple[:, 0] == pytest.approx(first, abs=1e-9)


def test_shapes_are_in_their_scales_and_counts_are_whole() -> None:
    made = probe(_counts=[7, 14], _kicks=[20, 7])
    assert list(made.shapes(COGS)) == [{"N_c": 7.0}, {"N_c": 14.0}, {"N_c": 20.0}]
    assert [*made.shapes(TERMS["ripple"])] == [{"N_r": 7.0}, {"N_r": 14.0}]
    assert list(made.shapes(DIRECTION)) == [{}]
    brushes = [one["i_b"] for one in made.shapes(TERMS["brush-drop"])]
    assert brushes == pytest.approx([3.0 * part for part in (0.02, 0.05, 0.15)])
    reaction = [one["i_K"] for one in made.shapes(TERMS["armature-reaction"])]
    assert reaction == pytest.approx([0.14, 3.5])


def test_counts_are_of_what_each_record_leaves_along_its_angle(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}
    noting(monkeypatch, score_derivatives, seen, turned="turned", periods_a_turn=[5])
    records = [
        SimpleNamespace(measured=[SimpleNamespace(values=np.array([x]))]) for x in (4.0, 9.0)
    ]
    made = object.__new__(Probe)
    base = [[np.array([1.0])], [np.array([2.0])]]
    vars(made).update(records=records, _angles=["a", "b"], _base=base)
    assert made._counts == [5]
    assert seen["turned"] == [(records[0], [3.0], "a"), (records[1], [7.0], "b")]
    assert seen["periods_a_turn"] == [(["turned", "turned"],)]


def test_each_record_is_probed_under_every_term_with_its_own_steps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What is held stays so; own unknowns that a term brings begin at nothing."""

    class Wide:
        def __init__(self, *given: Any) -> None:
            self.given, self.unknowns = given, (Unknown("warmth", 0.0), Unknown("offset", 0.0))

        def step_as(self, record: Any) -> None:
            self.steps = record

        def locate(self, shared: Any, own: Any) -> None:
            self.located = shared.tolist(), own.tolist()

        def fitted(self, shared: Any, own: Any) -> Any:
            return [shared, own]

    monkeypatch.setattr(score_derivatives, "WideRecord", Wide)
    monkeypatch.setattr(score_derivatives, "scales_of", lambda *of: of)
    records: Any = [SimpleNamespace(unknowns=(Unknown("offset", 0.0),)) for _ in range(2)]
    found: Any = SimpleNamespace(
        unknowns=(Unknown("R", 0.0), Unknown("J", 0.0)), own=(np.array([0.5]), np.array([0.7]))
    )
    values = {"R": 2.0, "J": 3.0, "B": 4.0, "T_lc": 0.1}
    made: Any = Probe(records, found, values)
    assert made.scales == (records, values)
    free = ("R", "J", *ADDED)
    for k, wide in enumerate(made.records):
        every = tuple(TERMS.values())
        assert wide.given == (records[k], free, {"B": 4.0}, every, made.scales, {}, k == 0)
        assert wide.steps is records[k]
        shared, own = wide.located
        known = dict(zip(free, shared, strict=True))
        assert (known["R"], known["J"], known["T_lc"]) == (2.0, 3.0, 0.1)
        assert known["d_T0"] == ADDED["d_T0"].absent
        assert own == [0.0, (0.5, 0.7)[k]]
    assert [base[1].tolist() for base in made._base] == [[0.0, 0.5], [0.0, 0.7]]


# a term's score


class Lines:
    """Scales of sizes, and two records."""

    names = ("R", "T0")
    records = (1, 2)
    scales = SimpleNamespace(
        of=lambda name: {"d_T0": 0.5, "T_c": 0.25, "k_K": 4.0, "T_lc": 2.0}[name]
    )


LINES: Any = Lines()


def scored(inverse: np.ndarray, slope: np.ndarray) -> Any:
    made = object.__new__(score_test._Test)
    found = SimpleNamespace(slopes=np.array([2.0, 1.0]))
    vars(made).update(probe=LINES, solution=found, inverse=inverse, slope=slope)
    return made


@pytest.mark.parametrize(("left", "told"), [(0.9e-6, False), (1.1e-6, True)])
def test_a_term_that_parameters_say_already_is_none(left: float, told: bool) -> None:
    """A millionth of its square must be left."""
    inverse = np.diag([0.25, 0.0])
    shared = np.array([[2.0 * np.sqrt((1.0 - left) * 9.0), 0.0]])
    sums = Sums(np.array([[9.0]]), shared, np.array([3.0]))
    one = Tried(DIRECTION, {}, (np.ones((1, 4)),))
    assert (scored(inverse, np.zeros(2))._candidate(one, [sums]) is not None) is told


@pytest.mark.parametrize(("pull", "term", "found"), [
    (-3.0, LOAD, False), (0.0, LOAD, False), (3.0, LOAD, True), (-3.0, DIRECTION, True),
])  # fmt: skip
def test_a_size_that_cannot_be_below_nothing_is_above(pull: float, term: Any, found: bool) -> None:
    sums = Sums(np.array([[9.0]]), np.zeros((1, 2)), np.array([pull]))
    one = Tried(term, {}, (np.ones((1, 4)),))
    got = scored(np.eye(2), np.zeros(2))._candidate(one, [sums])
    assert (got is not None) is found


def test_sizes_of_all_records_are_shared_or_each_its_own() -> None:
    """Of two records: by hand, with a parameter of which each shows a part."""
    inverse, slope = np.diag([0.5, 0.0]), np.array([0.2, 0.0])
    parts = [
        Sums(np.array([[s]]), np.array([[x, 0.0]]), np.array([p]))
        for s, x, p in ((9.0, 1.0, 4.0), (16.0, -3.0, 5.0))
    ]
    one = Tried(DIRECTION, {"x": 1.0}, (np.ones((1, 4)),) * 2)
    found = scored(inverse, slope)._candidate(one, parts)
    pull, information = 9.0 - 0.5 * -2.0 * 0.2, 25.0 - 0.5 * 4.0
    size = pull / information
    assert found.gain == pytest.approx(pull * size)
    assert found.start == pytest.approx({"x": 1.0, "d_T0": 0.5 * size})
    assert found.shift == pytest.approx({"R": -0.5 * -2.0 * size * 2.0, "T0": 0.0})
    assert (found.term, found.own, found.changes) == (DIRECTION, (), one.changes)
    both = [
        Sums(np.eye(2) * s, np.array([[x, 0.0], [0.0, 0.0]]), np.array([p, 2.0 * p]))
        for s, x, p in ((9.0, 1.0, 4.0), (16.0, -3.0, 5.0))
    ]
    turning = Tried(COGS, {"N_c": 7.0}, (np.ones((2, 4)),) * 2)
    apart = scored(inverse, slope)._candidate(turning, both)
    columns = np.array([1.0, 0.0, -3.0, 0.0])
    table = np.diag([9.0, 9.0, 16.0, 16.0]) - 0.5 * np.outer(columns, columns)
    pulls = np.array([4.0, 8.0, 5.0, 10.0]) - 0.5 * columns * 0.2
    sizes = np.linalg.solve(table, pulls)
    assert apart.gain == pytest.approx(pulls @ sizes)
    assert apart.shift["R"] == pytest.approx(-0.5 * columns @ sizes * 2.0)
    amplitude = np.mean([np.hypot(*sizes[:2]), np.hypot(*sizes[2:])])
    assert apart.start == pytest.approx({"N_c": 7.0, "T_c": 0.25 * amplitude})
    phases = [own["cogging phase"] for own in apart.own]
    assert phases == pytest.approx([np.arctan2(sizes[1], sizes[0]), np.arctan2(sizes[3], sizes[2])])


def test_a_ripple_of_the_resistance_begins_as_far_as_it_goes_with_that_of_the_constant() -> None:
    """Of each record: K by (3, 4) and R by (1, 2); by (0, 2) and (5, -1)."""
    one = Tried(RIPPLE, {"N_r": 7.0}, ())
    start, own = begins(LINES, one, np.array([3.0, 4.0, 1.0, 2.0, 0.0, 2.0, 5.0, -1.0]))
    amplitude = (5.0 + 2.0) / 2.0
    assert start == pytest.approx(
        {"N_r": 7.0, "k_K": 4.0 * amplitude, "k_R": (11.0 - 2.0) / 2.0 / amplitude}
    )
    assert [x["ripple phase"] for x in own] == pytest.approx([np.arctan2(4.0, 3.0), np.pi / 2])


def test_columns_of_each_shape_are_cut_from_the_sums_of_all(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Any] = []
    changes = np.arange(12.0).reshape(3, 4)

    def sums_of(table: Any, line: Any) -> Sums:
        seen.append((table.tolist(), line))
        return Sums(np.diag([1.0, 2.0, 3.0]), np.arange(6.0).reshape(3, 2), np.arange(3.0))

    monkeypatch.setattr(score_test, "sums_of", sums_of)
    tried = [Tried(DIRECTION, {}, (changes[:1],)), Tried(COGS, {}, (changes[1:],))]
    made = scored(np.eye(2), np.zeros(2))
    made.solution.records = ["line"]
    cut: list[Any] = []
    made._candidate = lambda one, parts: cut.append((one, parts[0])) or (one.term is COGS and "c")
    assert made.all(tried) == ["c"]
    assert seen == [(changes.tolist(), "line")]
    assert [one for one, _ in cut] == tried
    assert np.diag(cut[0][1].squares).tolist() == [1.0]
    assert np.diag(cut[1][1].squares).tolist() == [2.0, 3.0]
    assert cut[1][1].pull.tolist() == [1.0, 2.0]
    assert cut[1][1].shared.tolist() == [[2.0, 3.0], [4.0, 5.0]]
    assert made.all([]) == []


# lines that are foreseen


def line(n: int = 6) -> Linearised:
    rng = np.random.default_rng(2)
    return Linearised(
        rng.standard_normal(n), np.zeros((n, 2)), np.zeros((n, 1)), np.zeros((n, 2)),
        np.zeros(1), (), (slice(0, 2), slice(2, n)), np.array([0.5, 3.0]),
    )  # fmt: skip


@pytest.mark.parametrize("term", [DIRECTION, COGS])
def test_a_records_lines_are_its_residual_and_all_slopes(
    term: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sizes of a phase are each record's own: those of the others move nothing here."""
    monkeypatch.setattr(predicted_gain, "Straight", lambda *of: of)
    lines = (line(), line())
    known = Derivatives(
        np.zeros(2), (), (np.full((2, 6), 1.0), np.full((2, 6), 2.0)),
        (np.full((1, 6), 3.0), np.full((1, 6), 4.0)),
    )  # fmt: skip
    plain: Any = SimpleNamespace(records=lines, derivatives=known, own=("first", "second"))
    changes = (np.full((2, 6), 5.0), np.full((2, 6), 6.0))
    one = Candidate(term, 1.0, {}, {}, (), changes)
    record: Any = "record"
    found: Any = predicted_gain._straight(record, plain, one, 1)
    whose, left, table, slopes, starts = found
    assert (whose, starts) == ("record", "second")
    assert left == pytest.approx(lines[1].residual * np.array([0.5, 0.5, 3.0, 3.0, 3.0, 3.0]))
    assert slopes is known.own_slopes[1]
    assert table[:, 0].tolist() == ([2.0] * 2 + [6.0] * 2 if term is DIRECTION
                                    else [2.0] * 2 + [0.0] * 2 + [6.0] * 2)  # fmt: skip


def straight() -> Any:
    block = Block("a", 0.1, 3.0)
    measured = [SimpleNamespace(values=np.zeros(n), block=block, root_weights=None) for n in (2, 1)]
    twin = SimpleNamespace(measured=measured, whitened=None)
    record: Any = SimpleNamespace(
        twin=lambda: twin,
        unknowns=(Unknown("offset", 0.5, -1.0, 2.0, prior_mean=0.25, prior_sd=0.1),),
    )
    left = np.array([1.0, 2.0, 3.0])
    shared = np.array([[1.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 100.0]])
    return predicted_gain.Straight(
        record, left, shared, np.array([[1.0, 1.0, 1.0]]), np.array([0.75])
    )


def test_readings_are_straight_lines_in_the_first_of_all_sizes() -> None:
    """As many as are asked: the term's own come last. Moves begin at nothing, without bounds."""
    one = straight()
    whole = one.departures(np.array([2.0, 3.0, 4.0]), np.array([0.5]))
    assert [part.tolist() for part in whole] == [[-1.5, -28.5], [-397.5]]
    fewer = one.departures(np.array([2.0]), np.array([0.5]))
    assert [part.tolist() for part in fewer] == [[-1.5, 1.5], [2.5]]
    (unknown,) = one.unknowns
    assert (unknown.start, unknown.lower, unknown.upper) == (0.0, -np.inf, np.inf)
    assert (unknown.prior_mean, unknown.prior_sd) == (-0.5, 0.1)


def test_lines_are_weighed_by_noise_alone() -> None:
    one = straight()
    one.whiten([np.array([1.0, -0.5]), None])
    parts = [np.array([4.0, 6.0]), np.array([8.0])]
    assert [p.tolist() for p in one.weighed(parts)] == [[4.0], [8.0]]
    assert [p.tolist() for p in one.weighed(parts, filtered=False)] == [[4.0, 6.0], [8.0]]
    shared, own = one.weighed_lines()
    assert shared.tolist() == [[-0.5, 0.0], [10.0, 0.0], [0.0, 100.0]]
    assert own.tolist() == [[0.5, 1.0]]


def test_moves_are_searched_with_the_lines_own_derivatives(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}
    noting(monkeypatch, predicted_gain, seen, maximise="found")
    one = SimpleNamespace(
        unknowns=(1, 2), weighed_lines=lambda: (np.arange(9.0).reshape(3, 3), "o")
    )
    unknowns = [Unknown("a", 0.0), Unknown("b", 0.0)]
    assert predicted_gain._maximum(unknowns, [one], solution()) == "found"  # type: ignore[list-item,comparison-overlap]
    ((asked, records, enough, before),) = seen["maximise"]
    assert (asked, records, enough) == (unknowns, [one], ("enough", 0.01))
    lent = before[1].derivatives
    assert lent.at.tolist() == [0.0, 0.0]
    assert [own.tolist() for own in (*lent.own, *before[1].own)] == [[0.0, 0.0]] * 2
    assert lent.shared[0].tolist() == [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]
    assert lent.own_slopes == ("o",)


def test_terms_begin_together_from_the_screens_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two masses have no straight lines. The shape that suits the others best is taken."""
    seen: dict[str, Any] = {}
    tried = [Tried(LOAD, {"a": float(k)}, ()) for k in (1, 2, 3)] + [Tried(DIRECTION, {}, ())]
    noting(monkeypatch, joint_start, seen, Probe="probe", everything=tried, begins="begins")

    class Laid:
        def __init__(self, *given: Any) -> None:
            seen["laid"] = given

        def gain(self, chosen: Any) -> float:
            return {0: 5.0, 1: 9.0, 2: 7.0}[min(chosen)]

        def sizes(self, chosen: Any) -> Any:
            return {k: f"size {k}" for k in chosen}

    monkeypatch.setattr(joint_start, "_Lines", Laid)
    terms = [LOAD, TERMS["two-masses"], DIRECTION]
    found: Any = joint_start.starts(["r"], "s", {"R": 1.0}, terms)  # type: ignore[list-item,arg-type]
    assert found == {LOAD: "begins", DIRECTION: "begins"}
    assert seen["Probe"] == [(["r"], "s", {"R": 1.0})]
    assert seen["everything"] == [("probe", [LOAD, DIRECTION])]
    assert seen["laid"] == (tried, "s")
    asked = {one.term: (one, size) for _, one, size in seen["begins"]}
    assert asked == {LOAD: (tried[1], "size 1"), DIRECTION: (tried[3], "size 3")}


def test_one_capture_with_such_unknowns_carries_a_loss() -> None:
    drop, other = Unknown("brush drop", 0.0), Unknown("current offset", 0.0)
    one, bare = SimpleNamespace(unknowns=(other, drop)), SimpleNamespace(unknowns=(other,))
    assert carry_loss([bare, one])  # type: ignore[list-item]
    assert not carry_loss([bare, bare])  # type: ignore[list-item]
