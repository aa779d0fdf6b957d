"""docs/mistakes.md shows what is stored of the benches, and its tables are counted rightly."""

from __future__ import annotations

from bench.mistakes import page
from bench.mistakes.command import Answer
from bench.mistakes.score import HARMLESS, NAMED, SILENT, UNANSWERED, score

TRUTH = {"R": 2.0, "K": 0.05, "J": 1e-5}


def estimate(R: float | None, finding: str = "") -> Answer:
    """An answer whose R is that, known to 1 %, with a warning or none."""
    values = {"R": R, "K": 0.05, "J": 1e-5}
    parameters = {
        name: {
            "value": value,
            "uncertainty": {"total": 0.01 * TRUTH[name]},
            "interval_95": None if value is None else [0.98 * value, 1.02 * value],
            "status": "not_identifiable" if value is None else "estimated",
        }
        for name, value in values.items()
    }
    diagnostics = [{"code": finding, "severity": "warning", "message": ""}] if finding else []
    found = {"parameters": parameters, "diagnostics": diagnostics, "suspects": []}
    return Answer(0, found, "")


def test_the_page_shows_what_is_stored() -> None:
    text = page.PAGE.read_text(encoding="utf-8")
    assert page.filled(text) == text, "run python -m bench.mistakes.page"


def test_an_error_beyond_4_u_without_a_word_is_silent() -> None:
    assert score(estimate(2.07), TRUTH, ("gain",)).outcome == HARMLESS
    found = score(estimate(2.09), TRUTH, ("gain",))
    assert found.outcome == SILENT
    assert found.worst[0] == "R"
    assert abs(found.worst[1] - 4.5) < 1e-9
    assert score(estimate(2.09, "current_gain"), TRUTH, ("gain",)).outcome == NAMED
    assert score(estimate(None), TRUTH, ("gain",)).outcome == UNANSWERED
