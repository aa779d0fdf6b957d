"""Fits of cases: here, or in a child process with another commit's package."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
Values = dict[str, float | int | str | bool | None]
ALONE = {"OPENBLAS_NUM_THREADS": "1"}  # the same order of additions every time


@dataclass(frozen=True)
class Fitted:
    """One case's estimate laid flat, or why there is none; processor time in s."""

    values: Values
    seconds: float


def in_child(
    names: Sequence[str], package: Path = ROOT, environment: Mapping[str, str] | None = None
) -> dict[str, Fitted]:
    """The cases fitted by the ``motorid`` in the folder ``package``, in a process of their own."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "fitted.json"
        command = [sys.executable, str(Path(__file__)), str(package), str(out), *names]
        child = {**os.environ, **ALONE, **(environment or {})}
        child.pop("PYTHONPATH", None)
        subprocess.run(command, env=child, check=True, cwd=folder)
        found = json.loads(out.read_text(encoding="utf-8"))
    return {name: Fitted(**one) for name, one in found.items()}


def here(name: str) -> Fitted:
    """The case fitted in this process."""
    from motorid.errors import MotoridError
    from tests.frozen.cases import CASES, estimate
    from tests.frozen.flat import flat

    (case,) = (one for one in CASES if one.name == name)
    captures, began = case.captures(), time.process_time()
    try:
        values = flat(estimate(case, captures))
    except MotoridError as error:  # that too is an answer
        values = {"refused": f"{type(error).__name__}: {error}"}
    return Fitted(values, time.process_time() - began)


def main(package: str, out: str, *names: str) -> None:
    """What the child does: the package of one folder, the tests of this one."""
    sys.path[0] = package
    import motorid

    assert Path(motorid.__file__).resolve().is_relative_to(Path(package).resolve())
    sys.path[0] = str(ROOT)
    found = {name: vars(here(name)) for name in names}
    Path(out).write_text(json.dumps(found), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
