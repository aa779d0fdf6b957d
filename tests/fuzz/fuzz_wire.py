"""Fuzzes the wire's decoder and codec: ``python -m tests.fuzz.fuzz_wire --seconds 60``.

Needs atheris (libFuzzer for Python; Linux and macOS).
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["motorid.wire"]):
    from tests.fuzz.wire_checks import check, seeds

MAX_INPUT = 600


def main() -> None:
    """Fuzz for a while; libFuzzer says what it executes, and exits."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--found", type=Path, help="folder that keeps what opened new paths")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.found or Path(temporary)
        folder.mkdir(exist_ok=True)
        for number, data in enumerate(seeds()):
            (folder / f"seed{number}").write_bytes(data)
        limits = [f"-max_total_time={options.seconds}", f"-max_len={MAX_INPUT}", "-timeout=10"]
        crashes = f"-artifact_prefix={tempfile.gettempdir()}{os.sep}wire-"
        atheris.Setup([sys.argv[0], *limits, crashes, str(folder)], check)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
