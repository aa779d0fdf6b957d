"""The tool that tries mutants: which faults it makes, which tests it takes, what it keeps."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from tests.test_mutant_faults import SOURCE
from tools.mutants import c_faults, coverage_map, mutant, python_faults, score, trial, workplace
from tools.mutants.coverage_map import Map
from tools.mutants.mutant import Mutant, sample
from tools.mutants.trial import Answer, Kept


def test_a_sample_comes_again_and_outlives_an_edit_elsewhere() -> None:
    first = list(python_faults.mutants("a.py", SOURCE.encode()))
    moved = list(python_faults.mutants("a.py", SOURCE.replace("LARGEST = 2.5", "\n\n").encode()))
    order = [one.change for one in sample(first, 1)]
    assert order == [one.change for one in sample(reversed(first), 1)]
    assert order != [one.change for one in sample(first, 2)]
    assert [one.change for one in sample(moved, 1)] == [
        change for change in order if not change.startswith("LARGEST = 2.5")
    ]


def at(line: int, *, at_import: bool = False) -> Mutant:
    return Mutant("motorid/wire/a.py", line, "constant", 0, 1, "2", "1", "2", at_import)


KNOWN = Map(
    seconds={"tests/x/test_a.py::one": 0.1, "tests/wire/test_b.py::two": 5.0,
             "tests/x/test_a.py::three": 9.0, "tests/x/test_c.py::four": 1.0},
    lines={"tests/x/test_a.py::one": {"motorid/wire/a.py": [1, 2]},
           "tests/wire/test_b.py::two": {"motorid/wire/a.py": [2]},
           "tests/x/test_a.py::three": {}, "tests/x/test_c.py::four": {"motorid/wire/b.py": [2]}},
    tests={}, sources={},
)  # fmt: skip


@pytest.mark.slow
def test_tests_that_cover_the_line_come_first_then_their_files() -> None:
    own, quick, same_file = (
        "tests/wire/test_b.py::two",
        "tests/x/test_a.py::one",
        "tests/x/test_a.py::three",
    )
    assert KNOWN.covering(at(2)) == [own, quick, same_file]
    assert KNOWN.covering(at(1)) == [quick, same_file]
    assert KNOWN.covering(at(9, at_import=True)) == [own, quick, same_file]
    assert KNOWN.covering(at(9)) == [own, quick, same_file]  # a child may have run it unseen
    unknown = replace(at(1), path="motorid/wire/nobody_imports_it.py")
    assert KNOWN.covering(unknown) == []


def test_what_runs_on_import_meets_tests_that_go_through_its_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(coverage_map, "TREE", tmp_path)
    (tmp_path / "tests").mkdir()
    for name, line in (("a", "import motorid.wire"), ("b", "from motorid import wire")):
        (tmp_path / "tests" / f"test_{name}.py").write_text(f"{line}\n", encoding="utf-8")
    coverage_map.wholes.cache_clear()
    coverage_map.imports.cache_clear()
    try:
        assert coverage_map.looking_at_all("motorid/wire/deep/a.py") == {"tests/test_a.py"}
        assert coverage_map.looking_at_all("motorid/sim/a.py") == set()
        seconds = {"tests/test_a.py::one": 0.1, "tests/test_b.py::two": 0.1}
        known = Map(seconds, {test: {} for test in seconds}, {}, {})
        assert known.covering(at(2, at_import=True)) == ["tests/test_a.py::one"]
        assert known.covering(at(2)) == []
    finally:
        coverage_map.wholes.cache_clear()
        coverage_map.imports.cache_clear()


def test_the_tests_of_the_file_come_first_and_among_them_those_that_run_little(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lines = {
        "tests/wire/test_a.py::broad": {"motorid/wire/a.py": [2], "motorid/wire/b.py": [1, 2]},
        "tests/wire/test_a.py::narrow": {"motorid/wire/a.py": [2]},
        "tests/x/test_importer.py::narrow": {"motorid/wire/a.py": [1, 2]},
        "tests/wire/test_other.py::quick": {"motorid/wire/a.py": [2]},
        "tests/x/test_far.py::quick": {"motorid/wire/a.py": [2]},
    }
    seconds = {test: 0.1 if "quick" in test else 3.0 for test in lines}
    monkeypatch.setattr(coverage_map, "importing", lambda path: {"tests/x/test_importer.py"})
    monkeypatch.setattr(
        coverage_map, "test_files", lambda: sorted({t.split(":")[0] for t in lines})
    )
    assert Map(seconds, lines, {}, {}).covering(at(2)) == [
        "tests/wire/test_a.py::narrow", "tests/wire/test_a.py::broad",
        "tests/x/test_importer.py::narrow", "tests/wire/test_other.py::quick",
        "tests/x/test_far.py::quick",
    ]  # fmt: skip


def test_tests_beside_those_for_a_file_come_after_them(monkeypatch: pytest.MonkeyPatch) -> None:
    names = ["tests/wire/deep/test_z.py", "tests/wire/test_a.py", "tests/wire/test_b.py",
             "tests/x/test_far.py", "tests/x/test_importer.py"]  # fmt: skip
    monkeypatch.setattr(coverage_map, "test_files", lambda: names)
    monkeypatch.setattr(coverage_map, "importing", lambda path: {"tests/x/test_importer.py"})
    assert coverage_map.near("motorid/wire/a.py") == [
        "tests/wire/test_a.py", "tests/x/test_importer.py", "tests/wire/test_b.py",
    ]  # fmt: skip
    assert coverage_map.near("motorid/other/a.py") == ["tests/x/test_importer.py"]


def test_what_survives_one_round_of_tests_meets_the_next() -> None:
    killed = Answer("killed", "test_a.py::one", 2, 5, "digest")
    lived, unseen = Answer("survived", "", 3, 4), Answer("uncovered")
    later = iter([lived, killed, unseen])
    assert trial.in_turn(later) == replace(killed, tried=5, covering=9)
    assert list(later) == [unseen]  # nothing is tried after a kill
    assert trial.in_turn([lived, lived]) == Answer("survived", "", 6, 8)
    assert trial.in_turn([unseen, lived]) == lived
    assert trial.in_turn([unseen, unseen]) == unseen


def test_tests_of_some_folders_or_files_may_be_taken_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ["tests/a/test_x.py", "tests/ab/test_y.py", "tests/test_z.py"]
    noted: list[list[str]] = []
    monkeypatch.setattr(coverage_map, "test_files", lambda: names)
    monkeypatch.setattr(coverage_map, "test_digest", lambda name: name)
    monkeypatch.setattr(coverage_map, "_sources", lambda: iter(()))
    monkeypatch.setattr(
        coverage_map, "_noted", lambda files, _: noted.append(list(files)) or ({}, {})
    )
    for among in (("tests",), ("tests/a",), ("tests/a", "tests/test_z.py")):
        coverage_map.brought_up_to_date(tmp_path / f"{len(noted)}.json", "", among)
    assert noted == [names, names[:1], [names[0], names[2]]]


def test_the_budget_takes_the_first_tests_and_at_least_one() -> None:
    seconds = {"a": 5.0, "b": 2.0, "c": 1.0}
    assert trial.within(["a", "b", "c"], seconds, 7.0) == ["a", "b"]
    assert trial.within(["a", "b", "c"], seconds, 1.0) == ["a"]
    assert trial.within([], seconds, 1.0) == []


def test_an_answer_is_made_once(tmp_path: Path) -> None:
    answer = Answer("survived", "", 3, 4)
    assert Kept(tmp_path / "kept").get("key", lambda: answer) == answer
    assert Kept(tmp_path / "kept").get("key", lambda: Answer("killed")) == answer
    assert Kept(tmp_path / "kept").get("other", lambda: Answer("killed")) == Answer("killed")


def test_a_killed_mutant_is_tried_again_only_where_its_test_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "test_a.py").write_text("")
    monkeypatch.setattr(trial, "TREE", tmp_path)
    monkeypatch.setattr(trial, "test_digest", lambda path: f"first {path}")
    killed = Answer("killed", "test_a.py::one", 3, 4, "first test_a.py")
    kept = Kept(tmp_path / "kept")
    assert kept.killed("fault", lambda: killed) == killed
    again = Kept(tmp_path / "kept")
    assert again.killed("fault", lambda: Answer("survived")) == killed
    monkeypatch.setattr(trial, "test_digest", lambda path: f"second {path}")
    assert again.killed("fault", lambda: Answer("survived")) == Answer("survived")


def test_a_survivor_is_not_kept_for_other_tests(tmp_path: Path) -> None:
    kept = Kept(tmp_path / "kept")
    assert kept.killed("fault", lambda: Answer("survived")) == Answer("survived")
    assert kept.killed("fault", lambda: Answer("killed", "exit code 1")).outcome == "killed"


def test_survivors_that_some_of_their_tests_never_met_are_counted() -> None:
    made = [
        (at(1), Answer("survived", "", 3, 9)),
        (at(2), Answer("survived", "", 9, 9)),
        (at(3), Answer("killed", "x", 3, 9)),
    ]
    assert score.Score("wire", 100, made).half_tried == 1


def test_the_score_counts_what_no_test_covers_as_survived(monkeypatch: pytest.MonkeyPatch) -> None:
    outcomes = [*["killed"] * 17, "survived", "uncovered", "survived"]
    made = [(at(line), Answer(outcome)) for line, outcome in enumerate(outcomes)]
    made[-1] = (Mutant("motorid/wire/z.py", 1, "sign", 0, 1, "", "-a", "a"), Answer("survived"))
    found = score.Score("wire", 100, made)
    assert found.share == pytest.approx(0.85)
    assert found.good
    assert not score.Score("firmware", 100, made).good  # its goal is higher
    monkeypatch.setattr(score, "equivalent", lambda: {("motorid/wire/z.py", "-a -> a"): "squared"})
    assert found.share == pytest.approx(17 / 19)
    assert len(found.as_json()["survivors"]) == 2
    lazy = {("motorid/wire/a.py", "1 -> 2"): "lazy", ("motorid/wire/z.py", "-a -> a"): "lazy"}
    monkeypatch.setattr(score, "equivalent", lambda: lazy)
    assert found.share == 1.0
    assert not found.good  # more than a tenth is called equivalent


@pytest.mark.slow
def test_each_equivalent_mutant_has_a_reason_and_still_exists() -> None:
    for (path, change), why in mutant.equivalent().items():
        source = (mutant.ROOT / path).read_bytes()
        faults = (c_faults if path.endswith(".c") else python_faults).mutants(path, source)
        assert change in {one.change for one in faults}, f"{path}: {change}: take it off the list"
        assert len(why) > 20


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository of one function and two tests."""
    for module in (trial, coverage_map, workplace, mutant):
        for name in ("ROOT", "TREE", "HOME"):
            if hasattr(module, name):
                monkeypatch.setattr(module, name, tmp_path)
    (tmp_path / "toy").mkdir()
    (tmp_path / "toy" / "x.py").write_text(
        "def half(x: int) -> float:\n    return x / 2 if x > 1 else x\n"
    )
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "test_toy_mutants.py").write_text(
        "from toy.x import half\n"
        "def test_two(): assert half(2) == 1\n"
        "def test_one(): assert half(1) in (1, .5)\n"
    )
    tools = Path(workplace.__file__).parents[1]
    (tmp_path / "tools").symlink_to(tools, target_is_directory=True)
    return tmp_path


@pytest.mark.slow
def test_a_mutant_is_tried_by_its_tests_and_the_file_comes_back(tree: Path) -> None:
    source = (tree / "toy" / "x.py").read_bytes()
    tests = ["tests/test_toy_mutants.py::test_two", "tests/test_toy_mutants.py::test_one"]
    lines = {test: {"toy/x.py": [2]} for test in tests}
    known = Map(dict.fromkeys(tests, 0.1), lines, {}, {})
    found = {
        one.after: trial.try_python(one, known, Kept(tree / "kept"), 60.0)
        for one in python_faults.mutants("toy/x.py", source)
        if one.operator in ("arithmetic", "comparison") and "<=" not in one.after
    }
    seen_in = coverage_map.test_digest("tests/test_toy_mutants.py")
    assert found == {
        "return (x * 2) if x > 1 else x": Answer("killed", tests[0], 2, 2, seen_in),
        "return x / 2 if (x >= 1) else x": Answer("survived", "", 2, 2),
    }
    assert (tree / "toy" / "x.py").read_bytes() == source


def tried_near(tree: Path, source: bytes, *operators: str) -> dict[str, Answer]:
    """What the slow tests beside the toy say of its mutants of these kinds."""
    coverage_map.imports.cache_clear()
    return {
        one.after: trial.try_near(one, Kept(tree / "kept"), "slow", ("tests",), 60.0)
        for one in python_faults.mutants("toy/x.py", source)
        if one.operator in operators
    }


@pytest.mark.slow
def test_a_survivor_meets_the_tests_with_a_marker_that_were_written_for_its_file(
    tree: Path,
) -> None:
    (tree / "tests" / "test_toy_mutants.py").write_text(
        "import pytest\nfrom toy.x import half\n"
        "def test_two(): assert half(2) == 1\n"
        "@pytest.mark.slow\ndef test_three(): assert half(3) == 1.5\n"
        "@pytest.mark.slow\ndef test_one(): assert half(1) == 1\n"
    )
    source = (tree / "toy" / "x.py").read_bytes()
    found = tried_near(tree, source, "arithmetic", "comparison")
    name = "tests/test_toy_mutants.py"
    seen_in = coverage_map.test_digest(name)
    assert found == {
        "return (x * 2) if x > 1 else x": Answer("killed", f"{name}::test_three", 0, 0, seen_in),
        "return x / 2 if (x >= 1) else x": Answer("killed", f"{name}::test_one", 1, 1, seen_in),
        "return x / 2 if (x <= 1) else x": Answer("killed", f"{name}::test_three", 0, 0, seen_in),
    }
    assert (tree / "toy" / "x.py").read_bytes() == source
    elsewhere = trial.try_near(at(1), Kept(tree / "kept"), "slow", ("tests",), 60.0)
    assert elsewhere == Answer("uncovered")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits a process's work")
def test_a_test_that_fails_without_a_mutant_says_nothing_of_one(tree: Path) -> None:
    name = "tests/test_toy_mutants.py"
    (tree / name).write_text(
        "import pytest\nfrom toy.x import half\n"
        "@pytest.mark.slow\ndef test_sick(): assert half(2) == 7\n"
        "@pytest.mark.slow\ndef test_one(): assert half(1) == 1\n"
    )
    source = (tree / "toy" / "x.py").read_bytes()
    found = tried_near(tree, source, "comparison")
    seen_in = coverage_map.test_digest(name)
    assert found == {
        "return x / 2 if (x >= 1) else x": Answer("killed", f"{name}::test_one", 0, 0, seen_in),
        "return x / 2 if (x <= 1) else x": Answer("killed", f"{name}::test_one", 0, 0, seen_in),
    }
    assert (tree / "toy" / "x.py").read_bytes() == source


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits a process's work")
def test_what_turns_in_circles_ends_by_its_own_work(tree: Path) -> None:
    endless = [sys.executable, "-c", "while True: pass"]
    code, _ = workplace.run(endless, {}, 1.0)
    assert code == workplace.TIMED_OUT
    assert workplace.run([sys.executable, "-c", "print(2)"], {}, 60.0) == (0, "2\n")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux shows what a session's work is")
def test_what_waits_for_nothing_ends_and_what_works_does_not(
    tree: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workplace, "LOOK", 0.05)
    monkeypatch.setattr(workplace, "IDLE", 4)
    asleep = [sys.executable, "-c", "import signal; signal.pause()"]
    assert workplace.run(asleep, {}, 60.0) == (workplace.TIMED_OUT, "")
    monkeypatch.setattr(workplace, "_work", lambda session: (True, 0))  # ready, and never served
    assert workplace.run([sys.executable, "-c", "sum(range(10**7))"], {}, 60.0) == (0, "")
