"""What is said of two answers that differ: of bits, of numbers within a tolerance, of words."""

from __future__ import annotations

import math
import subprocess
from pathlib import Path

import pytest

from motorid.capture.model import CURRENT, POSITION
from tests.frozen import against, answers, compare, fits
from tests.frozen.answers import SHARPEST, WIDEST, Answer
from tests.frozen.cases import ANSWERS, CAPTURES, CASES, LOGS, MAPS, PACKED
from tests.frozen.compare import MOST_ROWS, Difference, table
from tests.frozen.flat import Flat, flat
from tests.frozen.perturb import RELATIVE, perturbed

R = "parameters > R"
ANSWER: Flat = {
    f"{R} > value": 2.0,
    f"{R} > uncertainty > total": 0.1,
    f"{R} > uncertainty > statistical": 1e-5,
    f"{R} > interval_95 > 0": 1.8,
    f"{R} > status": "estimated",
    "budget > R > noise": 0.1,
    "budget > R > clock": 1e-9,
    "correlation > K > R": 1e-3,
    "not_stated > current gain > R": 1e-9,
    "not_stated > current gain > L": 1e-9,
    "diagnostics > budget > message": "R is known to 5.01 %, after 170 evaluations",
    "diagnostics > better_model > moves > R": 1e-6,
    "diagnostics > better_model > sides > R > 0": 4.0,
    "models > six > evaluations": 170,
    "models > six > degrees_of_freedom": 1000,
}


def found(tolerance: float, **changed: object) -> list[tuple[str, float]]:
    """What differs where some paths, by their last two words, have other values."""
    other = {p: changed.get("_".join(p.split(" > ")[-2:]), v) for p, v in ANSWER.items()}
    seen = compare.beyond("case", ANSWER, other, lambda path: tolerance)  # type: ignore[arg-type]
    return [(d.path, d.size) for d in seen]


def test_a_value_and_its_interval_are_measured_by_the_uncertainty() -> None:
    ((path, size),) = found(1e-3, R_value=2.0002)
    assert path == f"{R} > value"
    assert size == pytest.approx(2e-3)
    assert found(3e-3, R_value=2.0002) == []
    assert len(found(1e-3, interval_95_0=1.8002)) == 1


def test_what_an_unstated_gain_would_change_is_measured_as_the_value_that_it_changes() -> None:
    ((_, size),) = found(1e-3, **{"current gain_R": 2e-4})
    assert size == pytest.approx(2e-3, rel=1e-4)  # of u, not of 1e-9
    ((_, size),) = found(1e-3, **{"current gain_L": 2e-9})
    assert size == pytest.approx(1.0)  # of itself, where the value has no u


def test_what_a_finding_moves_is_measured_by_the_uncertainty_or_by_itself_if_that_is_more() -> None:
    ((_, size),) = found(1e-3, moves_R=3e-4)
    assert size == pytest.approx(3e-3, rel=0.01)  # of u
    ((_, size),) = found(1e-3, R_0=4.2)
    assert size == pytest.approx(0.05)  # of 4 Ω


def test_parts_that_do_not_matter_are_measured_by_those_that_do() -> None:
    assert found(1e-2, uncertainty_statistical=2e-5, R_clock=1.1e-5) == []
    assert found(1e-2, uncertainty_total=0.102) == [
        (f"{R} > uncertainty > total", pytest.approx(0.02))
    ]
    assert found(1e-2, R_noise=0.102) == [("budget > R > noise", pytest.approx(0.02))]
    assert found(1e-2, K_R=9e-3) == []
    assert len(found(1e-2, K_R=2e-2)) == 1


@pytest.mark.parametrize("status", ["fixed", None])
def test_words_and_counts_differ_at_all(status: object) -> None:
    assert found(WIDEST, R_status=status) == [(f"{R} > status", math.inf)]
    assert found(WIDEST, six_degrees_of_freedom=1001)[0][1] == math.inf


def test_a_path_that_comes_or_goes_is_a_difference() -> None:
    less = {path: value for path, value in ANSWER.items() if "status" not in path}
    for pair in ((less, ANSWER), (ANSWER, less)):
        ((d,)) = compare.beyond("case", *pair, lambda path: WIDEST)
        assert (d.path, d.size) == (f"{R} > status", math.inf)


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("R is known to 5.02 %, after 170 evaluations", True),  # one in the last place
        ("R is known to 5.01 %, after 1,412 evaluations", True),  # each machine has its own
        ("R is known to 5.03 %, after 170 evaluations", False),
        ("R was known to 5.01 %, after 170 evaluations", False),
        ("R is known to 5.01 %", False),
    ],
)
def test_numbers_in_words_may_be_rounded_the_other_way(text: str, same: bool) -> None:
    assert (found(WIDEST, budget_message=text) == []) == same


def test_bits_are_all_that_counts_between_two_commits() -> None:
    assert compare.bits("case", ANSWER, dict(ANSWER)) == []
    other = ANSWER | {f"{R} > value": math.nextafter(2.0, 3.0), "models > six > evaluations": 171}
    assert [d.path for d in compare.bits("case", ANSWER, other)] == [
        "models > six > evaluations",
        f"{R} > value",
    ]
    assert [d.path for d in compare.bits("case", {"x": 1}, {"x": 1.0})] == ["x"]


def test_a_thousand_differences_are_one_table() -> None:
    many = [Difference("case", f"nuisance > n{k} > value", 1.0, 2.0, k) for k in range(1000)]
    lines = table(many).splitlines()
    assert len(lines) == 1 + MOST_ROWS + 1 + 1 + 2
    assert "n999 " in lines[1]  # the greatest first
    assert lines[-4:] == [
        ".. and 960 more",
        "",
        "by case: case 1000",
        "by part: nuisance 1000",
    ]
    assert table([]) == "no difference"


def test_a_tolerance_is_a_hundred_times_what_rounding_does_within_bounds() -> None:
    answer = Answer({}, {"parameters": 1e-5, "budget": 1e-9, "alternative": math.inf})
    assert answer.tolerance("parameters > R > value") == pytest.approx(1e-3)
    assert answer.tolerance("budget > R > noise") == answer.tolerance("model") == SHARPEST
    assert answer.tolerance("alternative > name") == WIDEST


def test_an_answer_is_stored_with_all_its_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(answers, "ANSWERS", tmp_path)
    values: Flat = {"a": 0.1 + 0.2, "b": 1, "c": None, "d": "Ω", "e": True}
    answers.save("case", Answer(values, {"parameters": 3e-5, "budget": 0.0}))
    stored = answers.load("case")
    assert compare.bits("case", values, stored.values) == []
    assert stored.moves == {"parameters": 1e-4}


def test_every_file_is_of_a_case_and_every_case_has_its_files() -> None:
    """What no case names would be carried along for ever."""
    needed = {(name if case.maps else f"{name}{PACKED}") for case in CASES for name in case.files}
    assert {path.name for folder in (CAPTURES, LOGS) for path in folder.iterdir()} == needed
    assert {path.stem for path in ANSWERS.iterdir()} == {case.name for case in CASES}
    assert set(MAPS) >= {"v", "i", "w", "p"}


def test_perturbed_readings_are_off_by_rounding_alone() -> None:
    (capture,) = next(case for case in CASES if case.name == "sim").captures()
    one, again, other = (perturbed(capture, seed) for seed in (1, 1, 2))
    for name in (CURRENT, POSITION):
        whole, values = capture.channels[name].values, one.channels[name].values
        assert (values == again.channels[name].values).all()
        assert (values != other.channels[name].values).any()
        offset = abs(capture.channels[name].offset * capture.channels[name].scale)
        assert (abs(values - whole) <= 6 * RELATIVE * (abs(whole) + offset)).all()
    turned = one.channels[POSITION].raw
    assert (turned == capture.channels[POSITION].raw).all()  # counts stay on their grid


@pytest.mark.slow
def test_a_child_gives_the_same_bits() -> None:
    name = "log-tachometer"
    child = fits.in_child([name])[name]
    assert compare.bits(name, child.values, fits.here(name).values) == []


def checkout(folder: Path) -> None:
    """A repository of a package with one C source, and what that was compiled to."""
    (folder / "motorid" / "motor").mkdir(parents=True)
    (folder / "motorid" / "motor" / "wave.c").write_text("int one;\n")
    (folder / ".gitignore").write_text("*.so\n")
    (folder / "setup.py").write_text("open('motorid/motor/_new.so', 'w').write('compiled')\n")
    for command in (
        ["init", "-q"],
        ["add", "-A"],
        ["-c", "user.name=a", "-c", "user.email=a@b", "commit", "-qm", "one"],
    ):
        subprocess.run(["git", "-C", str(folder), *command], check=True)
    (folder / "motorid" / "motor" / "_wave.so").write_text("library")


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    checkout(tmp_path)
    monkeypatch.setattr(against, "ROOT", tmp_path)
    return tmp_path


def test_another_commit_takes_over_what_is_compiled_from_the_same_c(repository: Path) -> None:
    with against.checked_out("HEAD") as folder:
        assert (folder / "motorid" / "motor" / "_wave.so").read_text() == "library"
        assert not (folder / "motorid" / "motor" / "_new.so").exists()
    assert not folder.exists()


def test_another_commit_is_compiled_where_its_c_differs(repository: Path) -> None:
    (repository / "motorid" / "motor" / "wave.c").write_text("int two;\n")
    with against.checked_out("HEAD") as folder:
        assert (folder / "motorid" / "motor" / "_new.so").read_text() == "compiled"
        assert not (folder / "motorid" / "motor" / "_wave.so").exists()


def test_a_commit_that_is_none_is_said(repository: Path) -> None:
    with pytest.raises(SystemExit, match="git worktree"), against.checked_out("nothing"):
        pass


def test_two_values_of_one_path_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    tree = {
        "inputs": [],
        "correlation": {"names": [], "matrix": []},
        "a": {"b > c": 1, "b": {"c": 2}},
    }
    monkeypatch.setattr("tests.frozen.flat.to_dict", lambda estimate: tree)
    with pytest.raises(ValueError, match="two values have the path 'a > b > c'"):
        flat(None)  # type: ignore[arg-type]
