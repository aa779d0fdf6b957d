"""Three motors through the emulated boards, beside the simulated one: docs/emulated-rig.md's table.

Each cell is the estimate's error in percent and, in brackets, half of its 95 % interval. A second
table has the errors of those with exact gains, offsets and clock; a Pico's converter is not exact.
Exit code 1 where an error passes 2 % (R, K, J) or 5 % (L, B, T0), or with exact gains the interval.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tests.emulated.motors import EXACT, MOST, MOTORS, NAMES, Figure, identify, truth

BOARDS = ("sim", "uno", "mega", "pico")
CAN_BE_EXACT = ("uno", "mega")


def main() -> int:
    print("| motor | board | " + " | ".join(NAMES) + " |")
    print("|---|---|" + "---:|" * len(NAMES))
    good = True
    for motor in MOTORS:
        true = " | ".join(f"{value:.4g}" for value in truth(motor).values())
        print(f"| {motor} | truth (SI) | {true} |")
        for board in BOARDS:
            found = identified(board, motor)
            cells = (f"{100 * f.error:+.2f} ({100 * f.relative_half:.2f})" for f in found.values())
            print(f"| | {board} | {' | '.join(cells)} |", flush=True)
            good &= all(abs(found[name].error) <= MOST[name] for name in NAMES)
    print("\n| motor | board | " + " | ".join(NAMES) + " |")
    print("|---|---|" + "---:|" * len(NAMES))
    for motor in MOTORS:
        for board in CAN_BE_EXACT:
            found = identified(board, motor, EXACT)
            cells = (f"{100 * f.error:+.2f}" for f in found.values())
            print(f"| {motor} | {board} | {' | '.join(cells)} |", flush=True)
            good &= all(abs(f.error) <= f.relative_half for f in found.values())
    return 0 if good else 1


def identified(board: str, motor: str, more: str = "") -> dict[str, Figure]:
    with tempfile.TemporaryDirectory() as folder:
        return identify(Path(folder), board, motor, more=more)


if __name__ == "__main__":
    sys.exit(main())
