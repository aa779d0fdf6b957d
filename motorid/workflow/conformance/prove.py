"""From a port and a rig to a bundle: where its files go, and what its end is."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from motorid.capture.whole import check_writable
from motorid.errors import RigError, UsageError
from motorid.workflow.conformance.evidence import Evidence

if TYPE_CHECKING:
    from motorid.rig import Rig

SUFFIX = ".zip"


def open_rig(name_or_path: str, device: str) -> tuple[Path, Rig]:
    """A rig's file and the rig as it stands, without its calibration, at ``device``.

    Raises RigError, also where its calibration lies elsewhere than beside it.
    """
    from motorid.rig_file import find, load_plain
    from motorid.workflow.record import adjusted

    path = find(name_or_path)
    rig = adjusted(load_plain(path), port=device)
    if rig.calibration_file:
        raise RigError(
            f"{path}: calibration.file names a file elsewhere: leave it out, so that the bundle's "
            "own calibration lies beside its copy of the rig"
        )
    return path, rig


def make_way(output: Path, *, force: bool) -> Path:
    """The folder for the bundle's files. Raises UsageError where it, or the bundle, is there."""
    if output.suffix != SUFFIX:
        raise UsageError(f"{output}: a bundle is a zip: name it {output.name}{SUFFIX}")
    check_writable(output, force=force)
    folder = output.with_suffix("")
    if folder.exists():
        if not force or not folder.is_dir():
            raise UsageError(f"{folder} exists already: name another bundle, or --force")
        shutil.rmtree(folder)
    return folder


def prove(evidence: Evidence, output: Path, *, force: bool) -> Path:
    """Gathers and writes the bundle, also where somebody presses Ctrl-C; returns its path."""
    finished = False
    try:
        evidence.gather()
        finished = True
    finally:
        if evidence.folder.is_dir():
            evidence.bundle(output, finished=finished, force=force)
    return output


def insist(evidence: Evidence, output: Path) -> None:
    """Raises RigError where a part failed: the bundle says which and why."""
    failed = [part for part in evidence.parts if part.name in evidence.failed()]
    if failed:
        names = ", ".join(part.name.replace("_", " ") for part in failed)
        raise RigError(f"{names} failed ({failed[0].says}): {output} holds what was measured")
