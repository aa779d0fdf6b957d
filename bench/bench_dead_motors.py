"""Dead motors and dead rigs, drawn: is each FAIL with its defect, INVALID, or judged as it should?

    python bench/bench_dead_motors.py [CASES=400] [FIRST=0]

One line of the simulated board measures all of them, a good motor after every fifth. A dead motor
must FAIL, a dead rig must be INVALID, a good motor must PASS. An open winding must FAIL at its
second contact.
"""

from __future__ import annotations

import re
import sys
import tempfile
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlencode

import numpy as np

from motorid.quality.product import SelfTest, load_product
from motorid.quality.verdict import Outcome, Verdict
from motorid.rig import load_rig
from motorid.workflow.check import Line

EVERY = 5
HIGHER = re.compile(r"\braise\b|\bhigher\b|\bincrease\b")


class Case(NamedTuple):
    """A kind, the simulated options, what the verdict must be, and how often it is measured."""

    kind: str
    options: dict[str, str]
    must: Outcome
    contacts: int = 1


def drawn(number: int) -> Case:
    """One case, with the spread of good motors under its fault."""
    rng = np.random.default_rng([2027, number])
    spread = {
        "copper": f"{rng.normal(1, 0.01):.5f}",
        "magnet": f"{rng.normal(1, 0.005):.5f}",
        "friction": f"{np.exp(rng.normal(0, 0.05)):.5f}",
        "seed": str(number + 1),
        "board": "11",
    }
    kinds = {
        "shorted": ({"copper": f"{rng.uniform(0.1, 0.3):.4f}"}, Outcome.FAIL),
        "seized": ({"fault": "stall"}, Outcome.FAIL),
        "cogging": ({"cogging": f"{rng.uniform(2e-3, 2e-2):.4g}"}, Outcome.FAIL),
        "reversed leads": ({"fault": "encoder_reversed"}, Outcome.FAIL),
        "wrong type": ({"winding": f"{rng.choice([0.5, 0.6, 1.6, 2.0]):g}"}, Outcome.FAIL),
        "open": (
            {"copper": "10", "lead_resistance": f"{rng.uniform(50, 100):.1f}", "sense": "bridge"},
            Outcome.FAIL,
        ),
        "encoder unplugged": ({"fault": "encoder_dead"}, Outcome.INVALID),
        "supply off": ({"fault": f"supply:{rng.uniform(0, 3):.2f}"}, Outcome.INVALID),
        "current sensor dead": ({"fault": "current_dead"}, Outcome.INVALID),
        "current sensor at its end": ({"fault": "current_saturated"}, Outcome.INVALID),
        "current sensor dies": (
            {"fault": f"current_dead@{rng.uniform(0.02, 0.2):.3f}"}, Outcome.INVALID,
        ),
        "voltage sense dead": ({"fault": "voltage_dead"}, Outcome.INVALID),
        "encoder dies": ({"fault": f"encoder_dead@{rng.uniform(0.02, 0.2):.3f}"}, Outcome.INVALID),
        "board unplugged": ({"fault": f"unplug@{rng.uniform(0.02, 0.3):.3f}"}, Outcome.INVALID),
        "good": ({}, Outcome.PASS),
    }  # fmt: skip
    kind = str(rng.choice(list(kinds)))
    more, must = kinds[kind]
    return Case(kind, spread | more, must, 2 if kind == "open" else 1)


def main(arguments: list[str]) -> int:
    """Prints the table; exit code 1 where a case went wrong."""
    count = int(arguments[0]) if arguments else 400
    first = int(arguments[1]) if len(arguments) > 1 else 0
    rig = load_rig("sim-line")
    product = replace(load_product("sim-disc"), self_test=SelfTest(dead_in_a_row=EVERY))
    seen: dict[str, Counter[str]] = {}
    wrong = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def inspect(number: int, options: dict[str, str]) -> Verdict:
            port = f"{rig.port}&speed=max&{urlencode(options)}"
            with Line(replace(rig, port=port), product, folder) as line:
                return line.inspect(f"D{number:06d}").verdict

        for number in range(first, first + count):
            print(f"case {number}", file=sys.stderr, flush=True)
            if (number - first) % EVERY == 0:
                inspect(900_000 + number, {})
            case = drawn(number)
            for _ in range(case.contacts):
                verdict = inspect(number, case.options)
            seen.setdefault(case.kind, Counter())[str(verdict.outcome)] += 1
            advises = [r for r in verdict.reasons if HIGHER.search(r)]
            if verdict.outcome is not case.must or advises:
                wrong += 1
                print(f"  {number} {case.kind} {case.options}: {verdict.outcome}, "
                      f"{' | '.join(verdict.reasons)[:300]}")  # fmt: skip
    for kind, outcomes in sorted(seen.items()):
        print(f"{kind:26s} {', '.join(f'{n} {o}' for o, n in sorted(outcomes.items()))}")
    print(f"{wrong} of {count} wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
