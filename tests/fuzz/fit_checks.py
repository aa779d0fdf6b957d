"""What a fit owes to any capture: finite numbers, or one sentence, and an end."""

from __future__ import annotations

import random
import re
import sys
import time
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from motorid.errors import MotoridError
from motorid.estimate.results.estimate import AUTO, SIX
from motorid.report import html, json_, text
from tests.fuzz.fit_damage import damaged, drawn
from tests.fuzz.sentence import check_sentence
from tests.six_parameters import fit

KEPT = Path(__file__).with_name("fit_corpus.txt")
MOST_EVALUATIONS = 20_000  # of a capture of a thousand samples at most: ten times a good fit's
NO_NUMBER = re.compile(r"(?<![\w-])[-+]?(nan|inf|infinity)(?![\w-])", re.IGNORECASE)


@dataclass(frozen=True)
class Outcome:
    """What became of a line: fitted or refused, and by how many evaluations."""

    word: str
    evaluations: int = 0
    said: str = ""


def seeds() -> list[str]:
    """What was found once."""
    lines = KEPT.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def check(line: str, model: str = SIX) -> Outcome:
    """Raises whatever is no promise of a fit kept: a warning of numpy counts as an error."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            estimate = fit([damaged(line)], model=model)
        except MotoridError as error:
            said = str(error)
            check_sentence(said, 0)
            assert "\n" not in said, said
            return Outcome("refused", said=said)
        pages = (text.render(estimate), json_.dumps(estimate), html.render(estimate))
    for page in pages:
        bare = re.search(NO_NUMBER, re.sub(r"<(script|style)\b.*?</\1>", "", page, flags=re.S))
        assert not bare, page[max(bare.start() - 100, 0) : bare.end() + 50]
    assert estimate.evaluations <= MOST_EVALUATIONS, estimate.evaluations
    return Outcome("fitted", estimate.evaluations)


def fuzz(cases: int, seconds: float, seed: int, first: int = 0) -> int:
    """Fits damaged captures; 1 when a promise was broken. Prints what broke, and the slowest."""
    seen: Counter[str] = Counter()
    said: Counter[str] = Counter()
    slowest: list[tuple[float, int, str]] = []
    began = time.monotonic()
    for number in range(first, first + cases):
        if time.monotonic() - began > seconds:
            break
        rng = random.Random(f"{seed}/{number}")
        line, model = drawn(rng), rng.choice((SIX, AUTO))
        start = time.process_time()
        try:
            outcome = check(line, model)
        except Exception:
            seen["broken"] += 1
            print(f"{model}: {line}\n{traceback.format_exc()}", file=sys.stderr, flush=True)
            continue
        seen[outcome.word] += 1
        said[outcome.said[:60]] += 1
        slowest.append((time.process_time() - start, outcome.evaluations, f"{model}: {line}"))
    print(f"Done {sum(seen.values())} runs: {dict(sorted(seen.items()))}", file=sys.stderr)
    for spent, evaluations, line in sorted(slowest, reverse=True)[:10]:
        print(f"{spent:6.1f} s {evaluations:6} evaluations  {line}", file=sys.stderr)
    for sentence, count in said.most_common(25):
        print(f"{count:5}  {sentence}", file=sys.stderr)
    return 1 if seen["broken"] else 0
