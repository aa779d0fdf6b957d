"""Logs of a bench that the others do not know: is anything wrong in silence, or accused in vain?

python bench/bench_stranger.py             every log, a motor each; writes the results
python bench/bench_stranger.py --short     a few
python bench/bench_stranger.py --drawn 40  so many good ones and spoilt ones, everything drawn
python bench/bench_stranger.py --kept out/stranger.jsonl   goes on where an earlier run stopped

Each log is a line of the file ``--kept`` once it is done. A later run of the same commit takes
such lines as they are, so the bench may run in parts.

A parameter or combination that is estimated and off by more than 4 u is SILENT where no word names
the cause. A good log counts as accused where anything is doubtful, warned of or refused.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import tempfile
import time
import zlib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.bench_mistakes import commit
from bench.mistakes.command import Answer
from bench.stranger import drawn
from bench.stranger.cases import BAD, GOOD
from bench.stranger.logs import Maker, answer
from bench.stranger.plant import draw

RESULTS = Path(__file__).resolve().parent / "results"
BEYOND_U, NORMAL_95 = 4.0, 1.96
SHORT = ("board, steps", "converter, steps", "w late, converter")
SAYS_NOTHING = ("rotor_held",)  # of a rotor that is held, a fact and no accusation


def truths(p: Mapping[str, float]) -> dict[str, float]:
    """The six and their combinations."""
    gain = p["K"] ** 2 + p["R"] * p["B"]
    ratios = {f"{n}/K": p[n] / p["K"] for n in ("J", "B", "T0")}
    squares = {f"{n}/K²": p[n] / p["K"] ** 2 for n in ("J", "B")}
    return {
        **p, **ratios, **squares, "JR/(K²+RB)": p["J"] * p["R"] / gain,
        "K/(K²+RB)": p["K"] / gain, "T0·R/K": p["T0"] * p["R"] / p["K"],
        "B/J": p["B"] / p["J"], "T0/J": p["T0"] / p["J"],
    }  # fmt: skip


def errors(found: Answer, truth: Mapping[str, float]) -> dict[str, tuple[str, float]]:
    """Status and error in u of what has an interval."""
    estimate = found.estimate or {}
    known = {**estimate.get("parameters", {}), **estimate.get("combinations", {})}
    out = {}
    for name, one in known.items():
        ends = [end for end in one.get("interval_95") or () if end is not None]
        if name in truth and one["value"] is not None and ends:
            low, high = ends
            u = (high - low) / 2.0 / NORMAL_95
            out[name] = (one["status"], (one["value"] - truth[name]) / max(u, 1e-300))
    return out


def judged(found: Answer, truth: Mapping[str, float], words: str) -> dict[str, Any]:
    """How a log ended; ``words`` name its mistake, none: it is good."""
    off = errors(found, truth)
    silent = {n: round(e, 1) for n, (s, e) in off.items() if s == "estimated" and abs(e) > BEYOND_U}
    doubtful = [n for n, (s, _) in off.items() if s in ("doubtful", "not_supported")]
    accused = [a for a in found.accusations if a.split(":")[0] not in SAYS_NOTHING]
    named = bool(words) and any(re.search(words, s, re.IGNORECASE) for s in found.sentences)
    if named:
        end = "named"
    elif silent and not accused and not doubtful:
        end = "SILENT"
    elif accused or doubtful:
        end = "misnamed" if words and silent else "doubtful" if words else "accused"
    else:
        end = "harmless"
    return {"end": end, "beyond": silent, "said": [a[:90] for a in accused[:2]]}


class Kept:
    """Rows of logs that are done, a JSON line each.

    Those of other commits are not taken, nor any where files differ from the commit.
    """

    def __init__(self, path: Path | None, of: str) -> None:
        self.path, self.commit = path, of
        lines = path.read_text(encoding="utf-8").splitlines() if path and path.exists() else []
        known = [one for line in lines if (one := _whole(line)) and one["commit"] == of]
        self.rows = {one["log"]: one["row"] for one in known if not of.endswith("+")}

    def add(self, log: str, row: Mapping[str, Any]) -> None:
        """Known from now on, and written at once."""
        self.rows[log] = row
        if self.path is not None:
            line = json.dumps({"commit": self.commit, "log": log, "row": row}, ensure_ascii=False)
            with self.path.open("a", encoding="utf-8") as out:
                out.write(line + "\n")


def _whole(line: str) -> dict[str, Any] | None:
    """A line that was written to its end."""
    try:
        return dict(json.loads(line))
    except ValueError:
        return None


def row_of(name: str, maker: Maker, words: str, seed: int, folder: Path) -> dict[str, Any]:
    """One log, drawn and judged; ``evaluations``: of each of its models."""
    began = time.process_time()
    rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
    motor = draw(rng)
    said = answer(maker(motor, rng), motor, rng, folder)
    truth = truths(motor.truth)
    if "locked" in name:
        truth = {n: truth[n] for n in "RL"}
    row = judged(said, truth, words)
    counted = [model["evaluations"] for model in (said.estimate or {}).get("models", ())]
    return {**row, "evaluations": counted, "cpu_s": round(time.process_time() - began, 1)}


def _listed() -> dict[str, tuple[Maker, str]]:
    """Every log of the lists by name, with the words that name its mistake."""
    good = {f"good: {n}": (m, "") for n, m in GOOD.items()}
    return good | {f"bad: {n}": pair for n, pair in BAD.items()}


def main() -> int:
    """Prints each log that did not end well; 1 where one was silent."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--short", action="store_true", help="a few logs")
    parser.add_argument("--drawn", type=int, default=0, help="draw so many logs instead")
    parser.add_argument("--only", default="", help="logs with that in their name")
    parser.add_argument("--seeds", type=int, nargs="*", default=[0])
    parser.add_argument("--out", type=Path, help="results file; default: of a full run")
    parser.add_argument("--kept", type=Path, help="file of a JSON line for each log that is done")
    chosen = parser.parse_args()
    cases = drawn.cases(chosen.drawn) if chosen.drawn else _listed()
    kept, rows = Kept(chosen.kept, commit()), {}
    with tempfile.TemporaryDirectory() as folder:
        for name, (maker, words) in cases.items():
            if chosen.only not in name or (chosen.short and name.split(": ")[1] not in SHORT):
                continue
            for seed in chosen.seeds[:1] if chosen.short else chosen.seeds:
                log = f"{name} [{seed}]"
                if log not in kept.rows:
                    kept.add(log, row_of(name, maker, words, seed, Path(folder)))
                rows[log] = row = kept.rows[log]
                if row["end"] not in ("named", "harmless") or row["beyond"]:
                    print(f"{row['end']:9s}{log}: {row['beyond']} {row['said']}", flush=True)
    ends = {
        k: Counter(r["end"] for n, r in rows.items() if n.startswith(k)) for k in ("good", "bad")
    }
    for kind, counts in ends.items():
        print(f"{kind}: " + ", ".join(f"{k} {v}" for k, v in counts.most_common()))
    full = not (chosen.short or chosen.only) and chosen.seeds == [0]
    usual = RESULTS / ("drawn_logs.json" if chosen.drawn else "stranger.json")
    if out := chosen.out or (usual if full else None):
        results = {"commit": kept.commit, "ends": ends, "logs": rows}
        out.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return 1 if any(counts["SILENT"] for counts in ends.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
