"""An emulated board on a pseudo terminal, for a host of its own process: POSIX, real time.

    python firmware/emulator/serve.py "emu://uno?motor=dunkermotoren-gr42"

prints the terminal's path, and for each line on standard input the pins and the motor as JSON.
"""

from __future__ import annotations

import json
import select
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from emu import Emulator

from motorid.errors import MotoridError
from motorid.sim.pty import offer


def say(text: str) -> None:
    print(text, flush=True)


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        board: Any = Emulator(sys.argv[1])
    except MotoridError as error:
        print(error, file=sys.stderr)
        return 1

    def is_over() -> bool:
        if not select.select([sys.stdin], [], [], 0)[0]:
            return False
        if not sys.stdin.readline():
            return True
        say(json.dumps(board.facts()))
        return False

    try:
        offer(board, say, is_over)
    finally:
        board.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
