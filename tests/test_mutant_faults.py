"""The faults that mutants are made of: in Python, in C, and what is left alone."""

from __future__ import annotations

import ast

import pytest

from tools.mutants import c_faults, python_faults

SOURCE = '''"""A module with 1 figure in its text."""
from typing import TYPE_CHECKING
LARGEST = 2.5
if TYPE_CHECKING:
    SEEN = 7
def scaled(ä: int | None, by: float = 3) -> float | None:
    assert by > 0
    if ä is None or not by:
        return None
    print(f"{by + 1}")
    return min(ä * by, LARGEST)
'''


def changes(source: str = SOURCE) -> dict[str, set[str]]:
    """The mutated lines, by operator."""
    found: dict[str, set[str]] = {}
    for one in python_faults.mutants("a.py", source.encode()):
        ast.parse(one.applied(source.encode()))
        found.setdefault(one.operator, set()).add(one.after)
    return found


def test_faults_in_python() -> None:
    assert changes() == {
        "constant": {
            "LARGEST = 7.5",
            "def scaled(ä: int | None, by: float = 4) -> float | None:",
        },
        "comparison": {"if (ä is not None) or not by:"},
        "boolean": {"if (ä is None and (not by)):"},
        "sign": {"if ä is None or (by):"},
        "condition": {"if (not (ä is None or not by)):"},
        "statement": {"pass"},
        "return": {"return None"},
        "function": {"return max(ä * by, LARGEST)"},
        "arithmetic": {"return min((ä / by), LARGEST)"},
    }


@pytest.mark.parametrize(
    ("line", "after"),
    [
        ("f(high, low)", "(f(low, high))"),  # of the same kind
        ("a <= b < c", "(a < b < c)"),
        ("x[1:]", "x[2:]"),
        ("x += y", "x -= y"),
        ("a if b else c", "(c if b else a)"),
        ("-a", "(a)"),
        ("any(a)", "all(a)"),
        ("True", "False"),
        ("9", "10"),
        ("10", "30"),
        ("0.5", "1.5"),
    ],
)
def test_each_kind_of_fault(line: str, after: str) -> None:
    assert after in set().union(*changes(line).values())


def test_an_assertion_is_no_behaviour() -> None:
    assert changes("def f(a: A, b: A) -> None:\n    assert a > b\n") == {}
    assert changes("pairs = zip(a, b, strict=True)") == {
        "arguments": {"pairs = (zip(b, a, strict=True))"}
    }


@pytest.mark.parametrize("line", ["max(a, b)", "math.hypot(a, b)", "np.maximum(a, b)"])
def test_arguments_that_may_change_places_are_left_where_they_are(line: str) -> None:
    assert "arguments" not in changes(line)


@pytest.mark.parametrize("line", ["np.max(a, b)", "x.maximum(a, b)", "np.arctan2(a, b)"])
def test_other_arguments_change_places(line: str) -> None:
    assert "arguments" in changes(line)


def test_only_what_runs_on_import_is_marked_so() -> None:
    found = python_faults.mutants("a.py", SOURCE.encode())
    assert {one.line for one in found if one.at_import} == {3, 6}


def test_faults_in_c_spare_comments_texts_and_pointers() -> None:
    source = b"""#define TOP 3
/* 1 + 1 */ static const char *said = "2 - 2"; // 3 < 4
int f(struct s *p) {
    if (!p->ready && *p->next <= 0x0Fu) {
        tell(&p->next);
    }
    return p->sum + 7;
}
"""
    found = {(one.line, one.operator, one.after) for one in c_faults.mutants("a.c", source)}
    assert found == {
        (4, "sign", "if (p->ready && *p->next <= 0x0Fu) {"),
        (4, "boolean", "if (!p->ready || *p->next <= 0x0Fu) {"),
        (4, "comparison", "if (!p->ready && *p->next < 0x0Fu) {"),
        (4, "comparison", "if (!p->ready && *p->next > 0x0Fu) {"),
        (4, "constant", "if (!p->ready && *p->next <= 16u) {"),
        (5, "statement", "(void)0;"),
        (7, "arithmetic", "return p->sum - 7;"),
        (7, "constant", "return p->sum + 8;"),
    }
