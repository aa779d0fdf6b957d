"""What a task costs on a Dask cluster, and the speed-up of fits with two workers.

    python bench/bench_cluster.py [CAPTURES=40] [TASKS=1000]

One process, then the same fits on a cluster of this computer with one and with two workers, in turn
and in one run. The cost of a task is that of TASKS tasks that do nothing. The last table is
computed from both figures and not measured: the client hands out one task after the other, so a
cluster is at best as fast as that.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path

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


def fitted(paths: list[Path], folder: Path, jobs: Workers) -> tuple[float, list[object]]:
    """Seconds a fit and the values; the first fifth of the fits is warm-up."""
    arrived: list[float] = []
    fits = fit_many(
        paths, folder, model=SIX, jobs=jobs, progress=lambda *_: arrived.append(time.perf_counter())
    )
    first = len(paths) // 5
    return (arrived[-1] - arrived[first]) / (len(arrived) - 1 - first), [f.values for f in fits]


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
        alone_s, alone = fitted(paths, folder / "alone", 1)
        one_s, one = fitted(paths, folder / "one", "local:1")
        two_s, two = fitted(paths, folder / "two", "local:2")
    load = os.getloadavg()[0]
    same = alone == one == two
    print(f"{count} captures, load average {load:.1f}")
    print(f"a fit, one process       {1e3 * alone_s:8.1f} ms")
    print(f"a fit, one worker        {1e3 * one_s:8.1f} ms   {alone_s / one_s:5.2f} times")
    print(f"a fit, two workers       {1e3 * two_s:8.1f} ms   {alone_s / two_s:5.2f} times")
    print(f"the same digits          {same}")
    for workers in ON_PAPER:
        times = min(workers, alone_s / cost)
        an_hour = 3600 / alone_s * times
        print(f"on paper, {workers:4} workers   {times:7.0f} times, {an_hour:,.0f} fits an hour")
    busy = load > 1.5 * (os.cpu_count() or 1)
    if busy:
        print("other programs hold the cores: times are shown and not judged")
    return int(not same or (not busy and alone_s / two_s < 2 * LEAST))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
