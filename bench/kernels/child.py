"""Fits subjects in a process of their own, under the kernel that its environment asks for."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bench.kernels.choice import checked, environment, in_force

Flat = dict[str, float | int | str | bool | None]
RIG = "rig "  # before the seed of a drawn rig; other subjects are frozen cases


def fitted(subjects: Sequence[str], folder: Path, kernel: str) -> dict[str, Flat]:
    """Each subject's estimate laid flat; rigs' captures lie in ``folder``.

    Raises SystemExit where another kernel was in force.
    """
    with tempfile.TemporaryDirectory() as passing:
        out = Path(passing) / "fitted.json"
        command = [sys.executable, str(Path(__file__)), str(folder), str(out), *subjects]
        subprocess.run(command, env=os.environ | environment(kernel), check=True)
        found = json.loads(out.read_text(encoding="utf-8"))
    checked(kernel, found)
    answers: dict[str, Flat] = found["answers"]
    return answers


def answer(subject: str, folder: Path) -> Flat:
    """One estimate, or in which words it was refused."""
    from bench.coverage.runs import kept
    from motorid.errors import MotoridError
    from motorid.workflow.fit import fit_captures
    from tests.frozen import fits
    from tests.frozen.flat import flat

    if not subject.startswith(RIG):
        return fits.here(subject).values
    runs = kept(folder, int(subject.removeprefix(RIG)))
    assert runs is not None
    try:
        return flat(fit_captures(runs.captures, model="six"))
    except MotoridError as error:
        return {"refused": f"{type(error).__name__}: {error}"}


def main(folder: str, out: str, *subjects: str) -> None:
    answers = {subject: answer(subject, Path(folder)) for subject in subjects}
    found = {"kernels": list(in_force()), "answers": answers}
    Path(out).write_text(json.dumps(found), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
