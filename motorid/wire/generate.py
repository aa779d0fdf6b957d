"""Writes what is derived from spec.toml: ``python -m motorid.wire.generate [--check]``.

Run from a source tree. With ``--check`` nothing is written; exit code 1 names the stale files.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from motorid.errors import MotoridError, UsageError
from motorid.wire import render_c, render_docs, render_enums
from motorid.wire.spec import Spec, load

ROOT = Path(__file__).resolve().parents[2]
TARGETS: Mapping[str, Callable[[Spec], str]] = {
    "motorid/wire/enums.py": render_enums.render,
    "firmware/core/wire_gen.h": render_c.render,
    "docs/protocol.md": render_docs.render,
}


def stale(root: Path, spec: Spec) -> dict[str, str]:
    """Files under ``root`` that do not say what the specification says, with what they should."""
    texts = {name: render(spec) for name, render in TARGETS.items()}
    return {name: text for name, text in texts.items() if _read(root / name) != text}


def _read(path: Path) -> str | None:
    return path.read_text(encoding="utf-8") if path.exists() else None


def write(root: Path, texts: Mapping[str, str]) -> None:
    """Put each text in its file, whatever the platform with plain line feeds."""
    for name, text in texts.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m motorid.wire.generate", description=__doc__)
    parser.add_argument(
        "--check", action="store_true", help="write nothing; 1 when a file is stale"
    )
    options = parser.parse_args(arguments)
    try:
        if not (ROOT / "pyproject.toml").exists():
            raise UsageError("motorid.wire.generate runs in a source tree, not in an installation")
        texts = stale(ROOT, load())
    except MotoridError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    if options.check:
        for name in texts:
            print(f"{name} is stale: run python -m motorid.wire.generate", file=sys.stderr)
        return 1 if texts else 0
    write(ROOT, texts)
    for name in texts:
        print(f"wrote {name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
