"""Plants that are not ours: how many headline intervals hold the truth of an ngspice or MuJoCo rig.

python bench/bench_foreign_plants.py --kind spice --rigs 12             plain motors
python bench/bench_foreign_plants.py --kind spice --rigs 12 --effects   with iron or windage
python bench/bench_foreign_plants.py --kind mujoco --rigs 12            needs the package mujoco
python bench/bench_foreign_plants.py --short                            one rig, shortened

The table counts every interval of the six-parameter rows, doubtful ones with it, and again without
them. The rigs' lines give each error over its standard uncertainty u. ``bench/foreign/drawn.py``
defines the truth. Results go to ``--out``; ``--keep`` keeps the captures for another fit.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.foreign import joint, spice
from bench.foreign.score import PLANTS, How, line, score, table

NEEDS = {
    "spice": (spice.available, "ngspice is not installed: apt-get install ngspice"),
    "mujoco": (joint.available, "the package mujoco is not installed: pip install mujoco"),
}


def main() -> int:
    """Draws, captures, fits and prints."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kind", choices=tuple(PLANTS), default="spice")
    parser.add_argument("--rigs", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1, help="of the first rig")
    parser.add_argument("--effects", action="store_true", help="one to three effects in each motor")
    parser.add_argument("--short", action="store_true", help="one rig, a tenth of a second of it")
    parser.add_argument("--keep", type=Path, help="folder in which captures stay")
    parser.add_argument("--out", type=Path, help="file that gets the records as JSON lines")
    chosen = parser.parse_args()
    available, advice = NEEDS[chosen.kind]
    if not available():
        print(advice, file=sys.stderr)
        return 2
    if chosen.keep is not None:
        chosen.keep.mkdir(parents=True, exist_ok=True)
    how = How(chosen.kind, chosen.effects, chosen.short, chosen.keep)
    rows = []
    for seed in range(chosen.seed, chosen.seed + (1 if chosen.short else chosen.rigs)):
        rows.append(score(seed, how))
        print(line(rows[-1]), flush=True)
        if chosen.out is not None:
            text = "".join(json.dumps(row) + "\n" for row in rows)
            chosen.out.write_text(text, encoding="utf-8")
    print(table(rows))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
