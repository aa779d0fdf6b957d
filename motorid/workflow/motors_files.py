"""Several motors into a folder: the page, the table, and the fits that make a run resumable."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from motorid.capture.whole import refuse_existing, write_whole
from motorid.errors import DataError
from motorid.estimate.results.estimate import SIX
from motorid.storage.place import Place
from motorid.workflow.many import captures_in, fit_many
from motorid.workflow.motors import Motor, motors, table
from motorid.workflow.motors_html import page
from motorid.workflow.tasks import Progress, Workers

MOST = 50  # motors that one page shows
PAGE, TABLE = "motors.html", "motors.csv"


def motors_to_files(
    places: Sequence[Place],
    folder: Path,
    *,
    jobs: Workers = -1,
    force: bool = False,
    progress: Callable[[], Progress] | None = None,
) -> tuple[list[Motor], list[Path]]:
    """Fits each capture by itself and writes page and table; the first motor is the reference.

    Finished fits are kept in the folder. Raises UsageError where a file exists, DataError for no
    motor or too many, and where none could be fitted.
    """
    paths = captures_in(places)
    if not 1 < len(paths) <= MOST:
        raise DataError(f"a page shows 2 to {MOST} captures, and {len(paths)} are named")
    folder.mkdir(parents=True, exist_ok=True)
    written = [folder / PAGE, folder / TABLE]
    for path in written:
        refuse_existing(path, force)
    bar = progress() if progress else None
    fits = fit_many(paths, folder, model=SIX, jobs=jobs, progress=bar)
    if all(fit.failure for fit in fits):
        raise DataError(f"none of {len(fits)} captures could be fitted: {fits[0].failure}")
    found = motors(paths, fits)
    for path, text in zip(written, (page(found), table(found)), strict=True):
        write_whole(path, text.encode(), force=force)
    return found, written
