"""Every number of every estimate of the corpus, against what was recorded.

python -m tests.frozen                      compare, within a tolerance
python -m tests.frozen --against HEAD~1     compare with that commit's fits, bit for bit
python -m tests.frozen --shake              fit perturbed readings; nothing may move by .01 u
python -m tests.frozen --record [NAME ..]   record new answers, and say what moved
"""

from __future__ import annotations

import argparse
import os
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is loaded

from tests.frozen import answers, compare, fits
from tests.frozen.against import against
from tests.frozen.answers import WIDEST, Answer
from tests.frozen.cases import ANSWERS, CASES, Case
from tests.frozen.compare import Difference
from tests.frozen.perturb import SEEDS, moves, shaken


def main() -> int:
    """0: nothing differs; 1: something does."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("python -m tests.frozen", None, __doc__, formatter_class=plain)
    parser.add_argument("names", nargs="*", metavar="NAME", help="cases; all of them unless given")
    mode = parser.add_mutually_exclusive_group()
    mode.add_argument("--record", action="store_true", help="record what the fits say now")
    mode.add_argument("--shake", action="store_true", help="perturb the readings by 1e-13")
    mode.add_argument("--against", metavar="REV", help="a commit; the fits must give its bits")
    chosen = parser.parse_args()
    cases = [case for case in CASES if not chosen.names or case.name in chosen.names]
    absent = set(chosen.names) - {case.name for case in CASES}
    if absent:
        parser.error(f"no case {', '.join(sorted(absent))}: see tests/frozen/cases.py")
    if chosen.against:
        found = against(chosen.against, [case.name for case in cases])
    else:
        look = record if chosen.record else shake if chosen.shake else held
        found = [difference for case in cases for difference in look(case)]
    print(compare.table(found))
    return 0 if chosen.record or not found else 1


def held(case: Case) -> list[Difference]:
    """What differs from the recorded answer; says in a line what the case cost."""
    recorded, fitted = answers.load(case.name), fits.here(case.name)
    found = compare.beyond(case.name, recorded.values, fitted.values, recorded.tolerance)
    said = f"{len(found)} of {len(recorded.values)} numbers and words differ"
    say(case.name, fitted.seconds, said + evaluations(recorded.values, fitted.values))
    return found


def shake(case: Case) -> list[Difference]:
    """What rounding alone changes of the recorded answer, by each of the seeds."""
    recorded, found = answers.load(case.name), []
    for seed in SEEDS:
        values = shaken(case, seed)
        found += compare.beyond(case.name, recorded.values, values, lambda path: WIDEST)
    print(f"{case.name:<28}{len(found)} differences of {len(SEEDS)} perturbations", flush=True)
    return found


def record(case: Case) -> list[Difference]:
    """Records the answer anew; what it differs from the last one by, bit for bit."""
    fitted = fits.here(case.name)
    answer = Answer(fitted.values, moves(case, fitted.values))
    last = answers.load(case.name).values if (ANSWERS / f"{case.name}.json").exists() else {}
    answers.save(case.name, answer)
    say(case.name, fitted.seconds, f"rounding moves it by {answer.most:.0e}")
    return compare.bits(case.name, last, fitted.values)


def say(name: str, seconds: float, text: str) -> None:
    print(f"{name:<28}{seconds:6.2f} s  {text}", flush=True)


def evaluations(old: fits.Values, new: fits.Values) -> str:
    """Where the count of evaluations moved, which is no difference."""
    counts = [path for path in old if path.endswith(compare.EVALUATIONS)]
    moved = [f"{old[p]} -> {new.get(p)}" for p in counts if old[p] != new.get(p)]
    return f"; evaluations {', '.join(moved)}" if moved else ""


if __name__ == "__main__":
    sys.exit(main())
