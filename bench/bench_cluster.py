"""What a task costs on a Dask cluster, and the speed-up of fits with two workers.

    python bench/bench_cluster.py [CAPTURES=40] [TASKS=1000]

One process, then the same fits on a cluster of this computer with one and with two workers, in turn
and in one run. The processor's time is that of all processes, client and scheduler among them; two
cores cannot be faster than twice one process's time over it, however quiet they are. The cost of a
task is that of TASKS tasks that do nothing. The last table is computed from both figures and not
measured: the client hands out one task after the other, so a cluster is at best as fast as that.
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import psutil

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as workers have it
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.bench_many import captures
from motorid.estimate.results.estimate import SIX
from motorid.workflow.many import fit_many
from motorid.workflow.task import Result, Task
from motorid.workflow.tasks import Workers, answers

LEAST = 0.8  # of the number of workers, on cores that nothing else uses
ON_PAPER = (10, 100, 1000)


def nothing(number: int) -> Result:
    """A task without work."""
    return {"number": number}


def cost_s(count: int, workers: str) -> float:
    """Seconds a task, without those of the cluster's start."""
    tasks = {n: Task(nothing, (n,), {}) for n in range(count)}
    arrived = [time.perf_counter() for _ in answers(tasks, workers)]
    return (arrived[-1] - arrived[count // 10]) / (count - 1 - count // 10)


class Fits(NamedTuple):
    """Seconds a fit, seconds of the processor a fit in all processes, and the values."""

    wall_s: float
    cpu_s: float
    values: list[object]


def processors_s() -> dict[int, float]:
    """Seconds of this process and its children, by number."""
    here = psutil.Process()
    found = {}
    for one in (here, *here.children(recursive=True)):
        with contextlib.suppress(psutil.NoSuchProcess):
            found[one.pid] = sum(one.cpu_times()[:2])
    return found


def fitted(paths: list[Path], folder: Path, jobs: Workers) -> Fits:
    """The first fifth of the fits is warm-up."""
    first = len(paths) // 5
    marks: list[tuple[float, dict[int, float]]] = []

    def progress(done: int, total: int) -> None:
        if done in (first, total):
            marks.append((time.perf_counter(), processors_s()))

    fits = fit_many(paths, folder, model=SIX, jobs=jobs, progress=progress)
    (began, before), (ended, after) = marks
    spent = sum(seconds - before.get(pid, 0.0) for pid, seconds in after.items())
    each = 1.0 / (len(paths) - first)
    return Fits((ended - began) * each, spent * each, [fit.values for fit in fits])


def main(arguments: list[str]) -> int:
    """Prints the figures; exit code 1 where one misses its target and the cores were free."""
    count = int(arguments[0]) if arguments else 40
    tasks = int(arguments[1]) if len(arguments) > 1 else 1000
    cost = cost_s(tasks, "local:2")
    print(f"{tasks} empty tasks: {1e3 * cost:.2f} ms each", flush=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "captures").mkdir()
        paths = captures(folder / "captures", count)
        alone = fitted(paths, folder / "alone", 1)
        one = fitted(paths, folder / "one", "local:1")
        two = fitted(paths, folder / "two", "local:2")
    load = os.getloadavg()[0]
    same = alone.values == one.values == two.values
    print(f"{count} captures, load average {load:.1f}")
    for name, found in (("one process", alone), ("one worker", one), ("two workers", two)):
        wall, cpu = 1e3 * found.wall_s, 1e3 * found.cpu_s
        times = alone.wall_s / found.wall_s
        print(f"a fit, {name:12}{wall:8.1f} ms, {times:5.2f} times; processor {cpu:8.1f} ms")
    print(f"two cores: at best       {2 * alone.cpu_s / two.cpu_s:8.2f} times one process")
    print(f"the same digits          {same}")
    for workers in ON_PAPER:
        times = min(workers, alone.wall_s / cost)
        an_hour = 3600 / alone.wall_s * times
        print(f"on paper, {workers:4} workers   {times:7.0f} times, {an_hour:,.0f} fits an hour")
    busy = load > 1.5 * (os.cpu_count() or 1)
    if busy:
        print("other programs hold the cores: times are shown and not judged")
    return int(not same or (not busy and alone.wall_s / two.wall_s < 2 * LEAST))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
