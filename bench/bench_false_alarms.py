"""False alarms: good logs and good captures, of which nothing may be accused.

python bench/bench_false_alarms.py             60 of each; writes bench/results/false_alarms.json
python bench/bench_false_alarms.py --count 2   two of each

Every second rig has a motor with cogging, ripple, a brush drop and stiction; the others are plain.
An accusation is a named fault, a doubtful or unsupported value, or a refusal. A better model of
effects that the motor has is none, nor is what it makes doubtful: it is found. Ends with 1
where an accusation is made, or where more than 5 % of the cases are warned of anything else.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.bench_mistakes import commit
from bench.mistakes.good import Good, good_capture, good_log
from bench.mistakes.score import score
from motorid.estimate.model.extended_terms import TERMS

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "bench" / "results" / "false_alarms.json"
MOST_WARNED = 0.05
OF_EFFECTS = ("better_model", "model_unsettled")  # findings that name what a motor has
KINDS: dict[str, Callable[[int, Path], Good]] = {"logs": good_log, "captures": good_capture}


@dataclass(frozen=True)
class Heard:
    """What one good case was told. ``accused`` and ``warned``: sentences; ``off``: errors in u.

    ``found``: what was said of effects that the motor has.
    """

    what: str
    accused: tuple[str, ...]
    warned: tuple[str, ...]
    off: dict[str, float]
    held: int
    of: int
    found: tuple[str, ...] = ()


def heard(good: Good) -> Heard:
    """Sorts what was said."""
    found = good.answer.estimate
    if found is None:
        return Heard(good.what, good.answer.accusations, (), {}, 0, 0)
    named = [f"{s['code']}: {s['evidence']}" for s in found["suspects"] if s["strength"] == "named"]
    poor = [
        f"{p['status']}: {name}"
        for name, p in good.answer.parameters.items()
        if p["status"] in ("doubtful", "not_supported")
    ]
    judged = score(good.answer, good.truth, ())
    said = [s for s in judged.said if s.split(": ")[0] not in {n.split(": ")[0] for n in named}]
    true = [one for one in said if _names_what_is(one, good.has)]
    if true and not named:
        true, poor = [*true, *poor], []
    intervals = {n: found["parameters"][n]["interval_95"] for n in good.truth}
    known = {n: pair for n, pair in intervals.items() if pair}
    return Heard(
        what=good.what,
        accused=(*named, *poor),
        warned=tuple(s for s in said if s not in true),
        off={n: x for n, x in judged.errors.items() if abs(x) > 4},
        held=sum(low <= good.truth[n] <= high for n, (low, high) in known.items()),
        of=len(known),
        found=tuple(true),
    )


def _names_what_is(sentence: str, has: frozenset[str]) -> bool:
    """It speaks of effects, and of none that the motor lacks."""
    code, _, words = sentence.partition(": ")
    spoken = {name for name, term in TERMS.items() if term.title in words}
    return code in OF_EFFECTS and bool(spoken) and spoken <= has


def summary(cases: Sequence[Heard]) -> dict[str, Any]:
    """Counts, and which codes."""
    plain = [c for c in cases if "real motor" not in c.what]
    codes = Counter(s.split(": ")[0] for c in cases for s in {*c.accused, *c.warned})
    return {
        "cases": len(cases),
        "accused": sum(bool(c.accused) for c in cases),
        "warned_or_accused": sum(bool(c.accused or c.warned) for c in cases),
        "of_plain_motors": {
            "cases": len(plain),
            "warned_or_accused": sum(bool(c.accused or c.warned) for c in plain),
        },
        "true_effect_found": sum(bool(c.found) for c in cases),
        "beyond_4_u": sum(bool(c.off) for c in cases),
        "intervals_held": sum(c.held for c in cases),
        "intervals": sum(c.of for c in cases),
        "codes": dict(codes.most_common()),
    }


def main() -> int:
    """Prints what was said of each case that was told anything; 1 where a goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=60, help="cases of each kind")
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    parser.add_argument("--kinds", nargs="*", choices=list(KINDS), default=list(KINDS))
    parser.add_argument("--out", type=Path, help="results file; default: of a full run")
    chosen = parser.parse_args()
    results: dict[str, Any] = {"commit": commit(), "first": chosen.first}
    good = True
    with tempfile.TemporaryDirectory() as temporary:
        for kind in chosen.kinds:
            cases = []
            for seed in range(chosen.first, chosen.first + chosen.count):
                one = heard(KINDS[kind](seed, Path(temporary)))
                cases.append(one)
                for sentence in (*one.accused, *one.warned, *(f"true: {s}" for s in one.found)):
                    print(f"{one.what}: {' '.join(sentence.split())[:150]}", flush=True)
                if one.off:
                    sizes = ", ".join(f"{n} {x:+.1f} u" for n, x in one.off.items())
                    print(f"{one.what}: beyond 4 u: {sizes}", flush=True)
            counts = summary(cases)
            print(f"{kind}: " + ", ".join(f"{k} {v}" for k, v in counts.items()))
            good &= not counts["accused"]
            good &= counts["warned_or_accused"] <= MOST_WARNED * len(cases)
            told = [vars(c) for c in cases if c.accused or c.warned or c.off or c.found]
            results[kind] = {**counts, "told": told}
    full = (chosen.count, chosen.first, len(chosen.kinds)) == (60, 0, len(KINDS))
    if out := chosen.out or (RESULTS if full else None):
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
