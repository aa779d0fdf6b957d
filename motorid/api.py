"""The few calls that a script needs; the command line makes the same ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motorid.acquire.record import Progress
    from motorid.capture.model import Capture
    from motorid.estimate.types import Estimate
    from motorid.rig import Rig


def fit(
    *captures: Capture | str | PathLike[str],
    fix: Mapping[str, float] | None = None,
    without: Sequence[str] = (),
    method: str = "ml",
) -> Estimate:
    """The estimate that captures of one motor, or the files that hold them, give together.

    ``fix`` holds parameters at known SI values; ``without`` leaves some out of the model. Raises
    DataError where a capture is none or too little, UsageError on an unknown name.
    """
    from motorid.capture import store
    from motorid.estimate import fit as estimate

    loaded = [store.load(Path(c)) if isinstance(c, str | PathLike) else c for c in captures]
    return estimate(loaded, fix=fix or {}, without=without, method=method)


def record(
    rig: Rig | str,
    path: str | PathLike[str],
    *,
    force: bool = False,
    serial: str = "",
    note: str = "",
    progress: Progress | None = None,
) -> Path:
    """Drives the rig's motor through its program and writes the capture to ``path``.

    Raises RigError, LinkError, or UsageError where ``path`` exists and ``force`` is not given.
    """
    from motorid.acquire import record as recorder
    from motorid.rig import load_rig

    bench = load_rig(rig) if isinstance(rig, str) else rig
    return recorder.capture(
        bench,
        bench.program,
        Path(path),
        force=force,
        progress=progress,
        serial=serial,
        note=note,
    )
