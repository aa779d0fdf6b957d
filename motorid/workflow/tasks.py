"""Many independent computations on all cores, or a cluster, each result a file: go on later.

A task's file is named by a digest of everything that defines it, so a changed definition runs
again and an equal one does not.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from motorid import json_text
from motorid.capture.whole import write_whole
from motorid.errors import DataError
from motorid.workflow.task import Result as Result
from motorid.workflow.task import Task as Task

Progress = Callable[[int, int], None]  # done, total
Workers = int | str  # processes (-1: one a core), or a cluster as ``--cluster`` names it
Key = TypeVar("Key", bound=Hashable)


def run_all(
    tasks: Sequence[Task], folder: Path, jobs: Workers = -1, progress: Progress | None = None
) -> list[Result]:
    """Results in the order of the tasks; those that ``folder`` holds already are read, not run.

    An interrupt keeps every result that was finished, and so does a cluster that is lost. What has
    a ``failure`` is not kept: what one run cannot read, the next one may. Raises as ``answers``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{task.digest}.json" for task in tasks]
    found = {path: result for path in paths if (result := _read(path)) is not None}
    missing = {path: task for path, task in zip(paths, tasks, strict=True) if path not in found}
    if progress:
        progress(len(found), len(paths))
    for path, result in answers(missing, jobs):
        if not result.get("failure"):
            write_whole(path, json_text.dumps(result).encode(), force=True)
        found[path] = result
        if progress:
            progress(len(found), len(paths))
    return [found[path] for path in paths]


def answers(tasks: Mapping[Key, Task], jobs: Workers) -> Iterator[tuple[Key, Result]]:
    """Each task's key and result as they finish.

    A task that no worker of a cluster survives gives its ``failed``; without one it raises
    DataError. Raises LinkError where the cluster cannot be reached or is lost.
    """
    if isinstance(jobs, str):
        yield from _of_cluster(tasks, jobs)
        return
    if jobs == 1 or len(tasks) < 2:
        yield from (_do(key, task) for key, task in tasks.items())
        return
    from joblib import Parallel, delayed

    pool = Parallel(n_jobs=min(jobs, len(tasks)), return_as="generator_unordered")
    yield from pool(delayed(_do)(key, task) for key, task in tasks.items())


def _of_cluster(tasks: Mapping[Key, Task], address: str) -> Iterator[tuple[Key, Result]]:
    from motorid.workflow.cluster import Failure, answered, check_address

    check_address(address)
    for key, found in answered(tasks, address) if tasks else ():
        if not isinstance(found, Failure):
            yield key, found
            continue
        failed = tasks[key].failed
        if failed is None:
            raise DataError(f"a task of the cluster failed: {found.says}; the others are kept")
        yield key, failed(found.says)


def _do(key: Key, task: Task) -> tuple[Key, Result]:
    return key, json_text.plain(task.work(*task.arguments))  # as it will be read again


def _read(path: Path) -> Result | None:
    """The result in a file; None where there is none, or one that no version of this wrote."""
    try:
        return json_text.read_object(path, DataError)
    except DataError:
        return None
