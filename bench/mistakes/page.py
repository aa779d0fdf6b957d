"""The tables of docs/mistakes.md from the results of the three benches.

python -m bench.mistakes.page            writes them into the document
python -m bench.mistakes.page --check    ends with 1 where the document lags behind
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bench.mistakes.score import BEYOND_U, NAMED, OUTCOMES

ROOT = Path(__file__).resolve().parents[2]
PAGE, RESULTS = ROOT / "docs" / "mistakes.md", ROOT / "bench" / "results"
MEANS = {
    "named": "a finding or a refusal names the cause",
    "harmless": f"every error is within {BEYOND_U:g} u, and nothing is accused",
    "listed": "the report lists the cause among the faults that leave no trace",
    "unanswered": "R, K or J is withheld without its cause",
    "doubtful": "what is wrong is marked doubtful, without its cause",
    "misnamed": "something else is named, or a refusal says nothing of the cause",
    "SILENT": f"an error beyond {BEYOND_U:g} u without any warning",
}


def main(arguments: Sequence[str]) -> int:
    """Writes or checks the document."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    chosen = parser.parse_args(arguments)
    old = PAGE.read_text(encoding="utf-8")
    new = filled(old)
    if chosen.check:
        if old != new:
            print(f"{PAGE.name} lags behind bench/results: python -m bench.mistakes.page")
        return int(old != new)
    PAGE.write_text(new, encoding="utf-8")
    return 0


def filled(page: str) -> str:
    """The page with its tables anew, each between its marks."""
    mistakes, chain, alarms = (_stored(n) for n in ("mistakes", "log_chain", "false_alarms"))
    blocks = {
        "counts": counts(mistakes),
        "mistakes": table(mistakes),
        "missed": missed(mistakes),
        "doubtful": doubtful(mistakes),
        "chain": chained(chain),
        "alarms": alarmed(alarms),
    }
    for name, text in blocks.items():
        marks = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end -->)", re.DOTALL)
        assert marks.search(page), f"no marks for {name} in {PAGE.name}"
        page = marks.sub(lambda m, t=text: m[1] + t + m[2], page, count=1)
    return page


def _stored(name: str) -> Any:
    return json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))


def counts(results: Mapping[str, Any]) -> str:
    """How many mistakes ended how."""
    summary = results["summary"]
    rows = [f"| {name} | {MEANS[name]} | {summary[name]} |" for name in OUTCOMES]
    head = ["| ends | which means | mistakes |", "|---|---|---|"]
    last = f"| all | commit {results['commit']} | {summary['mistakes']} |"
    return "\n".join([*head, *rows, last]) + "\n"


def _worst(row: Mapping[str, Any]) -> tuple[str, float]:
    worst = max((m["worst"] for m in row["motors"].values()), key=lambda one: abs(one["u"]))
    return worst["parameter"], worst["u"]


def table(results: Mapping[str, Any]) -> str:
    """A row a mistake."""
    lines = ["| mistake | in | ends | largest unmarked error | words |", "|---|---|---|---|---|"]
    for row in results["mistakes"]:
        name, u = _worst(row)
        error = f"{name} {u:+.3g} u" if name and abs(u) > BEYOND_U else "—"
        lines.append(
            f"| {row['name']} | {row['where']} | {row['outcome']} | {error} | {_words(row)} |"
        )
    return "\n".join(lines) + "\n"


def _words(row: Mapping[str, Any]) -> str:
    """The code of the finding that names the cause, or "refused"."""
    by = [m["named_by"] for m in row["motors"].values() if m["named_by"]]
    codes = dict.fromkeys(re.match(r"\w+", sentence).group() for sentence in by)  # type: ignore[union-attr]
    plain = [f"`{code}`" if "_" in code or code == "import" else code for code in codes]
    return ", ".join(plain) or "—"


def missed(results: Mapping[str, Any]) -> str:
    """What no finding names although it spoils the answer, worst first."""
    lines = []
    for row in results["mistakes"]:
        wrong = [
            (abs(u), f"{parameter} {m['errors_percent'][parameter]:+.3g} % ({motor})")
            for motor, m in row["motors"].items()
            if m["outcome"] not in (NAMED, "harmless")
            for parameter, u in m["errors_u"].items()
            if abs(u) > BEYOND_U and m["status"][parameter] not in ("doubtful", "not_supported")
        ]
        if wrong:
            size, words = max(wrong)
            lines.append((size, f"- {row['name']}, in a {row['where']}: {words}, {size:.3g} u"))
    return "\n".join(text for _, text in sorted(lines, reverse=True)) + "\n"


def doubtful(results: Mapping[str, Any]) -> str:
    """How wide the intervals of doubtful values are beside their errors."""
    found = [
        d
        for row in results["mistakes"]
        for m in row["motors"].values()
        for d in m["doubtful"].values()
    ]
    if not found:
        return "No value was doubtful.\n"
    held = sum(d["holds"] for d in found)
    return f"{len(found)} values were doubtful; the interval of {held} holds the truth.\n"


def chained(results: Mapping[str, Any]) -> str:
    """Totals, then a row a fault and size."""

    def cells(one: Mapping[str, Any]) -> str:
        apart = f"{one['doubtful_held']} of {one['doubtful']}" if one["doubtful"] else "—"
        return f"{one['held']} of {one['of']} | {apart} | {one['near']} of {one['near_of']}"

    head = "| fault | size | stated | intervals that hold | doubtful that hold | R, K, J in 2 % |"
    lines = [head, "|---|---|---|---|---|---|"]
    for name, total in results["all"].items():
        lines.append(f"| all: {name} | | | {cells(total)} |")
    for row in results["faults"]:
        for stated, words in (("not stated", "no"), ("stated", "yes")):
            lines.append(f"| {row['fault']} | {row['size']:g} | {words} | {cells(row[stated])} |")
    return "\n".join(lines) + "\n"


def alarmed(results: Mapping[str, Any]) -> str:
    """A row a kind of good case."""
    head = (
        "good", "accused", "warned at all", "of plain motors", "a true effect named",
        "beyond 4 u", "intervals hold",
    )  # fmt: skip
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for kind in ("logs", "captures"):
        one = results[kind]
        plain = one["of_plain_motors"]
        lines.append(
            f"| {one['cases']} {kind} | {one['accused']} | {one['warned_or_accused']} "
            f"| {plain['warned_or_accused']} of {plain['cases']} "
            f"| {one['true_effect_found']} | {one['beyond_4_u']} "
            f"| {one['intervals_held']} of {one['intervals']} |"
        )
    codes = {k: v for kind in ("logs", "captures") for k, v in results[kind]["codes"].items()}
    said = ", ".join(f"`{code}`" for code in codes) or "nothing"
    return "\n".join(lines) + f"\n\nSaid of them: {said}.\n"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
