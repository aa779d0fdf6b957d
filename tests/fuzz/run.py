"""Fuzzes one of the parsers: ``python -m tests.fuzz.run wire --seconds 60``.

Parsers in Python are fuzzed by atheris (libFuzzer for Python; Linux and macOS), which is led by
coverage. Readers of binary files run in children, where no coverage is seen; their inputs are
changed at random, by a seed (see ``files``). So are the words of boards (see ``board``). ``fit``
damages captures absurdly and fits them.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import tempfile
from pathlib import Path

from tests.fuzz.targets import BOARDS, FILES, FIT, PARSERS

INPUT_S = 60  # of wall time; an input that takes longer is a hang, also on a busy computer
MEMORY_MB = 1500


def main() -> None:
    """Fuzzes for a while; says what it executed, and exits with an error on a broken promise."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target", choices=[*PARSERS, *FILES, *BOARDS, FIT])
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--runs", "--cases", type=int, default=-1, help="executions at most")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--found", type=Path, help="folder that keeps what opened new paths")
    options = parser.parse_args()
    if options.target == FIT:
        from tests.fuzz.fit_checks import fuzz as fits

        cases = options.runs if options.runs >= 0 else sys.maxsize
        sys.exit(fits(cases, options.seconds, options.seed))
    if options.target in BOARDS:
        from tests.fuzz.board import fuzz as fuzz_board

        sys.exit(fuzz_board(options.seconds, options.runs, options.seed))
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.found or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        if options.target in FILES:
            from tests.fuzz.files import fuzz

            sys.exit(fuzz(options.target, options.seconds, options.runs, options.seed, folder))
        led_by_coverage(options, folder)


def led_by_coverage(options: argparse.Namespace, folder: Path) -> None:
    """Hands a parser to atheris, which never returns."""
    import atheris

    target = PARSERS[options.target]
    with atheris.instrument_imports(include=list(target.instrumented)):
        checks = importlib.import_module(target.checks)
    for number, data in enumerate(checks.seeds()):
        (folder / f"seed{number}").write_bytes(data)
    arguments = [
        f"-max_total_time={options.seconds}",
        f"-runs={options.runs}",
        f"-seed={options.seed}",
        f"-max_len={target.longest}",
        f"-timeout={INPUT_S}",
        f"-rss_limit_mb={MEMORY_MB}",
        "-print_final_stats=1",
        "-verbosity=0",
        f"-artifact_prefix={tempfile.gettempdir()}{os.sep}{options.target}-",
    ]
    atheris.Setup([sys.argv[0], *arguments, str(folder)], checks.check)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
