"""How a mistake ended: named, harmless, doubtful, misnamed, or silent."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bench.mistakes.command import Answer

BEYOND_U = 4.0  # standard uncertainties: an error that a reader must be warned of
NAMED = "named"  # a finding or a refusal names the cause
HARMLESS = "harmless"  # no error beyond that, nothing accused
UNANSWERED = "unanswered"  # R, K or J is withheld, and nothing names the cause
LISTED = "listed"  # errors, and the report lists the cause among what data cannot reveal
DOUBTFUL = "doubtful"  # what is wrong is marked, but its cause is not named
MISNAMED = "misnamed"  # something else is named, rightly or not
SILENT = "SILENT"  # an error beyond that, and no finding at all
OUTCOMES = (NAMED, HARMLESS, LISTED, UNANSWERED, DOUBTFUL, MISNAMED, SILENT)  # from good to bad
ALWAYS = ("R", "K", "J")  # that each of these rigs and logs tells when nothing is wrong
TRUSTED = ("estimated", "at_bound")


@dataclass(frozen=True)
class Score:
    """One mistake on one motor. ``errors``: in u, by parameter; ``worst``: of those trusted.

    ``doubted``: of each doubtful parameter half its interval over its error, and whether it holds.
    """

    outcome: str
    code: int
    errors: Mapping[str, float]
    percent: Mapping[str, float]
    status: Mapping[str, str]
    worst: tuple[str, float]
    doubted: Mapping[str, tuple[float, bool]]
    said: tuple[str, ...]
    by: str  # the sentence that names the cause; empty: none does

    def kept(self) -> dict[str, Any]:
        """For the results file."""
        return {
            "outcome": self.outcome,
            "exit_code": self.code,
            "errors_u": {name: float(f"{x:.3g}") for name, x in self.errors.items()},
            "errors_percent": {name: float(f"{x:.3g}") for name, x in self.percent.items()},
            "status": dict(self.status),
            "doubtful": {
                name: {"half_width_over_error": float(f"{ratio:.3g}"), "holds": holds}
                for name, (ratio, holds) in self.doubted.items()
            },
            "worst": {"parameter": self.worst[0], "u": float(f"{self.worst[1]:.3g}")},
            "named_by": _short(self.by),
            "said": [_short(one) for one in self.said[:3]],
        }


def _short(sentence: str) -> str:
    """Its beginning, without the folder of a file."""
    return re.sub(r"(?<!\S)/(\S+/)+", "", sentence)[:160]


def score(
    answer: Answer,
    truth: Mapping[str, float],
    causes: Sequence[str],
    traceless: Sequence[str] = (),
) -> Score:
    """Judges an answer against the true parameters and the words that name the cause."""
    errors, percent, status, doubted = {}, {}, {}, {}
    for name, true in truth.items():
        found = answer.parameters.get(name)
        if not found:
            continue
        status[name] = found["status"]
        if found["value"] is None:
            continue
        off = found["value"] - true
        total = (found.get("uncertainty") or {}).get("total") or 0.0
        errors[name] = off / total if total else float("inf") if off else 0.0
        percent[name] = 100 * off / true
        low, high = found["interval_95"] or (true, true)
        if found["status"] == "doubtful":
            doubted[name] = ((high - low) / 2 / max(abs(off), 1e-300), low <= true <= high)
    trusted = {n: x for n, x in errors.items() if status[n] in TRUSTED}
    worst = max(trusted.items(), key=lambda one: abs(one[1]), default=("", 0.0))
    by = _naming(answer, causes)
    return Score(
        outcome=_outcome(answer, worst, status, bool(by), traceless),
        code=answer.code,
        errors=errors,
        percent=percent,
        status=status,
        worst=worst,
        doubted=doubted,
        said=answer.accusations,
        by=by,
    )


def _naming(answer: Answer, causes: Sequence[str]) -> str:
    """The sentence that names one of the causes."""
    plain = {
        s: re.sub(r"(?<=\d)\.(?=\d)", "", s) for s in answer.sentences
    }  # a stop ends a sentence
    said = (s for c in causes for s, p in plain.items() if re.search(c, p, re.IGNORECASE))
    return next(said, "")


def _outcome(
    answer: Answer,
    worst: tuple[str, float],
    status: Mapping[str, str],
    named: bool,
    traceless: Sequence[str],
) -> str:
    if named:
        return NAMED
    if answer.estimate is None:
        return MISNAMED
    if any(s in ("doubtful", "not_supported") for s in status.values()):
        return DOUBTFUL if abs(worst[1]) <= BEYOND_U else MISNAMED
    if answer.accusations:
        return MISNAMED
    if abs(worst[1]) <= BEYOND_U:
        return HARMLESS if all(status.get(n) in TRUSTED for n in ALWAYS) else UNANSWERED
    return LISTED if set(traceless) & set(answer.traceless) else SILENT
