"""Many independent computations on all cores, or a cluster, each result a file: go on later.

A task's file is named by a digest of everything that defines it, so a changed definition runs
again and an equal one does not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from motorid import json_text
from motorid.capture.whole import write_whole
from motorid.errors import DataError
from motorid.workflow.task import Result as Result
from motorid.workflow.task import Task as Task

Progress = Callable[[int, int], None]  # done, total
Workers = int | str  # processes (-1: one a core), or a cluster as ``--cluster`` names it


def run_all(
    tasks: Sequence[Task], folder: Path, jobs: Workers = -1, progress: Progress | None = None
) -> list[Result]:
    """Results in the order of the tasks; those that ``folder`` holds already are read, not run.

    An interrupt keeps every result that was finished, and so does a cluster that is lost. A task
    that no worker of a cluster survives gives its ``failed``, which is not kept; without one it
    raises DataError. Raises LinkError where the cluster cannot be reached or is lost.
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


def _finished(missing: Mapping[Path, Task], jobs: Workers) -> Any:
    if isinstance(jobs, str):
        yield from _of_cluster(missing, jobs)
        return
    if jobs == 1 or len(missing) < 2:
        yield from (_do(path, task) for path, task in missing.items())
        return
    from joblib import Parallel, delayed

    pool = Parallel(n_jobs=min(jobs, len(missing)), return_as="generator_unordered")
    yield from pool(delayed(_do)(path, task) for path, task in missing.items())


def _of_cluster(missing: Mapping[Path, Task], address: str) -> Iterator[tuple[Path, Result]]:
    from motorid.workflow.cluster import Failure, answered, check_address

    check_address(address)
    for path, found in answered(missing, address) if missing else ():
        if not isinstance(found, Failure):
            if not found.get("failure"):  # a capture that one machine cannot read, another may
                write_whole(path, json_text.dumps(found).encode(), force=True)
            yield path, found
            continue
        failed = missing[path].failed
        if failed is None:
            raise DataError(f"a task of the cluster failed: {found.says}; the others are kept")
        yield path, failed(found.says)


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
