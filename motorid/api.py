"""The few calls that a script needs; the command line makes the same ones."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.errors import DataError

if TYPE_CHECKING:
    from motorid.acquire.record import Progress
    from motorid.capture.model import Capture
    from motorid.estimate.results.estimate import Estimate
    from motorid.quality.product import Product
    from motorid.quality.verdict import Verdict
    from motorid.rig import Rig
    from motorid.workflow.connect import Connection


def fit(
    *captures: Capture | str | PathLike[str] | Iterable[Capture | str | PathLike[str]],
    rig: Rig | str | None = None,
    fix: Mapping[str, float] | None = None,
    without: Sequence[str] = (),
    method: str = "ml",
    model: str = "auto",
    ambient: tuple[float, float] | None = None,
    nameplate: Mapping[str, float] | None = None,
) -> Estimate:
    """The estimate that captures of one motor, or the files that hold them, give together.

    ``captures``: one after another, or as a list. ``rig``: re-analyse them under this rig (its
    name, its file), with its calibration, in place of the one they were taken with. ``fix`` holds
    parameters at known SI values; ``without`` leaves some out of the model. ``model``: six, auto (a
    better one beside the answer, where the data ask for it), or terms joined by +. ``ambient``: °C
    and standard uncertainty (K), in place of what the captures hold. ``nameplate``: figures of the
    motor by the keys of a rig file's [nameplate] and [thermal]. Raises DataError where a capture is
    none or too little, UsageError on an unknown name, RigError where the rig is not of these
    captures.
    """
    from motorid.rig import load_rig
    from motorid.rig_nameplate import of_numbers
    from motorid.workflow.fit import fit_captures

    loaded = [run for one in captures for run in _loaded(one)]
    bench = load_rig(rig) if isinstance(rig, str) else rig
    return fit_captures(
        loaded, rig=bench, ambient=ambient, nameplate=of_numbers(nameplate) if nameplate else None,
        fix=fix or {}, without=without, method=method, model=model,
    )  # fmt: skip


def _loaded(one: Any) -> list[Capture]:
    """The captures that an argument of ``fit`` stands for."""
    from motorid.capture import store
    from motorid.capture.model import Capture

    if isinstance(one, Capture):
        return [one]
    if isinstance(one, str | PathLike):
        return [store.load(Path(one))]
    if isinstance(one, Iterable):
        return [run for each in one for run in _loaded(each)]
    raise DataError(f"{one!r} is no capture: give captures, or the files that hold them")


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
    from motorid.workflow.record import adjusted

    bench = adjusted(load_rig(rig) if isinstance(rig, str) else rig)
    return recorder.capture(
        bench,
        bench.program,
        Path(path),
        force=force,
        progress=progress,
        serial=serial,
        note=note,
    )


def connect(rig: Rig | str) -> Connection:
    """The board of a rig, held open: ``with connect(rig) as board: capture = board.run(program)``.

    Raises RigError where there is no such rig, LinkError where the port cannot be opened.
    """
    from motorid.rig import load_rig
    from motorid.workflow.connect import Connection
    from motorid.workflow.record import adjusted

    return Connection(adjusted(load_rig(rig) if isinstance(rig, str) else rig))


def load_product(name_or_path: str | PathLike[str]) -> Product:
    """The product, with its program and its limits, of a packaged name or a TOML file.

    Raises UsageError naming file and key.
    """
    from motorid.quality.product import load_product as load

    return load(Path(name_or_path) if isinstance(name_or_path, PathLike) else name_or_path)


def judge(
    estimate: Estimate, limits: Product | str | PathLike[str], *, serial: str = ""
) -> Verdict:
    """PASS, FAIL or INVALID, per measurement and whole, by a product or the name or path of one.

    ``serial`` stands in where the captures name none. Raises UsageError for a bad product file.
    """
    from motorid.quality.judge import judge as decide

    product = load_product(limits) if isinstance(limits, str | PathLike) else limits
    return decide(estimate, product, serial=serial)
