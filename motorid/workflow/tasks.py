"""Many independent computations on all cores, each result a file: interrupt and go on later.

A task's file is named by a digest of everything that defines it, so a changed definition runs
again and an equal one does not.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorid import json_text
from motorid.capture.whole import write_whole
from motorid.errors import DataError

Result = dict[str, Any]  # plain data for JSON
Progress = Callable[[int, int], None]  # done, total


@dataclass(frozen=True)
class Task:
    """``work(*arguments)`` gives a Result; ``definition``, plain data, is all it depends on."""

    work: Callable[..., Result]
    arguments: tuple[Any, ...]
    definition: Mapping[str, Any]

    @property
    def digest(self) -> str:
        """Name of the result's file."""
        text = json_text.canonical(self.definition)
        return hashlib.sha256(text.encode()).hexdigest()[:24]


def run_all(
    tasks: Sequence[Task], folder: Path, jobs: int = -1, progress: Progress | None = None
) -> list[Result]:
    """Results in the order of the tasks; those that ``folder`` holds already are read, not run.

    ``jobs``: processes (-1: one a core). An interrupt keeps every result that was finished.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{task.digest}.json" for task in tasks]
    found = {path: result for path in paths if (result := _read(path)) is not None}
    missing = {path: task for path, task in zip(paths, tasks, strict=True) if path not in found}
    if progress:
        progress(len(found), len(paths))
    for path, result in _finished(missing, jobs):
        found[path] = result
        if progress:
            progress(len(found), len(paths))
    return [found[path] for path in paths]


def _finished(missing: Mapping[Path, Task], jobs: int) -> Any:
    if jobs == 1 or len(missing) < 2:
        yield from (_do(path, task) for path, task in missing.items())
        return
    from joblib import Parallel, delayed

    pool = Parallel(n_jobs=min(jobs, len(missing)), return_as="generator_unordered")
    yield from pool(delayed(_do)(path, task) for path, task in missing.items())


def _do(path: Path, task: Task) -> tuple[Path, Result]:
    result = json_text.plain(task.work(*task.arguments))  # as it will be read again
    write_whole(path, json_text.dumps(result).encode(), force=True)
    return path, result


def _read(path: Path) -> Result | None:
    """The result in a file; None where there is none, or one that no version of this wrote."""
    try:
        return json_text.read_object(path, DataError)
    except DataError:
        return None
