"""Three motors through the emulated boards, beside the simulated one: docs/emulated-rig.md's table.

Each cell is the estimate's error in percent and, in brackets, half of its 95 % interval. Exit code
1 where an error passes 2 % (R, K, J) or 5 % (L, B, T0).
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tests.emulated.motors import MOST, MOTORS, NAMES, identify, truth

BOARDS = ("sim", "uno", "mega")


def main() -> int:
    print("| motor | board | " + " | ".join(NAMES) + " |")
    print("|---|---|" + "---:|" * len(NAMES))
    good = True
    for motor in MOTORS:
        true = " | ".join(f"{value:.4g}" for value in truth(motor).values())
        print(f"| {motor} | truth (SI) | {true} |")
        for board in BOARDS:
            with tempfile.TemporaryDirectory() as folder:
                found = identify(Path(folder), board, motor)
            cells = (f"{100 * f.error:+.2f} ({100 * f.relative_half:.2f})" for f in found.values())
            print(f"| | {board} | {' | '.join(cells)} |", flush=True)
            good &= all(abs(found[name].error) <= MOST[name] for name in NAMES)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
