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
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motorid.capture.model import Capture
    from tests.frozen.cases import Case

ROOT = Path(__file__).resolve().parents[2]
Values = dict[str, float | int | str | bool | None]
ALONE = {"OPENBLAS_NUM_THREADS": "1"}  # the same order of additions every time


@dataclass(frozen=True)
class Fitted:
    """One case's answer, and the processor time of its fit, s."""

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
    from tests.frozen.cases import CASES

    (case,) = (one for one in CASES if one.name == name)
    captures, began = case.captures(), time.process_time()
    return Fitted(answer(case, captures), time.process_time() - began)


def answer(case: Case, captures: Sequence[Capture]) -> Values:
    """The estimate of these captures laid flat; or in which words there is none."""
    from motorid.errors import MotoridError
    from tests.frozen.cases import estimate
    from tests.frozen.flat import flat

    try:
        return flat(estimate(case, captures))
    except MotoridError as error:
        return {"refused": f"{type(error).__name__}: {error}"}


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
