"""Cost per capture and speed-up of ``motorid fit --jobs``. Options: number of captures, processes.

    python bench/bench_many.py [CAPTURES=60] [JOBS=cores]        (10000 for the full line)

The captures are inspections of the simulated line (rigs/sim-line.toml, products/sim-disc.toml,
0.31 s at 10 kHz); CAPTURES of them are fitted with the six parameters, as a station does, on one
process and on several, both from empty folders, then once more from a finished folder.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

from motorid.acquire.record import capture
from motorid.capture import store
from motorid.estimate.results.estimate import SIX
from motorid.quality.product import load_product
from motorid.rig import load_rig
from motorid.workflow.many import Fitted, fit_many

MOST_PER_CAPTURE_MS = 5.0  # what may come on top of the fits themselves, a capture
LEAST_SPEED_UP = 0.6  # of the number of processes, on cores that nothing else uses
DIFFERENT = 12  # simulated runs; the rest repeat them with another note, as other files


def captures(folder: Path, count: int) -> list[Path]:
    """So many capture files, all of different bytes.

    Another process writes them: what a process has written it reads quicker than workers do.
    """
    with ProcessPoolExecutor(1, get_context("spawn")) as writer:
        writer.submit(_write, folder, count).result()
    return sorted(folder.glob("*.h5"))


def _write(folder: Path, count: int) -> None:
    rig, program = load_rig("sim-line"), load_product("sim-disc").program
    for seed in range(min(count, DIFFERENT)):
        one = replace(rig, port=f"{rig.port}&seed={seed + 1}&speed=max")
        capture(one, program, folder / f"{seed:05d}.h5")
    for k in range(DIFFERENT, count):
        first = store.load(folder / f"{k % DIFFERENT:05d}.h5")
        other = replace(first, provenance={**first.provenance, "note": f"copy {k}"})
        store.save(other, folder / f"{k:05d}.h5")


def timed(paths: list[Path], folder: Path, jobs: int) -> tuple[float, list[Fitted]]:
    """Seconds of one whole call, and its answers."""
    began = time.perf_counter()
    fits = fit_many(paths, folder, model=SIX, jobs=jobs)
    return time.perf_counter() - began, fits


def main(arguments: list[str]) -> int:
    """Prints the figures; exit code 1 where one misses its target."""
    count = int(arguments[0]) if arguments else 60
    jobs = int(arguments[1]) if len(arguments) > 1 else os.cpu_count() or 1
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "captures").mkdir()
        with ProcessPoolExecutor(1) as other:  # files of another process, as a user's are
            paths = other.submit(captures, folder / "captures", count).result()
        one_s, alone = timed(paths, folder / "alone", 1)
        many_s, together = timed(paths, folder / "together", jobs)
        again_s, _ = timed(paths, folder / "together", jobs)
    fits_s = sum(fit.seconds for fit in alone)
    over_ms = 1e3 * (one_s - fits_s) / count
    same = [f.values for f in alone] == [f.values for f in together]
    print(f"{count} captures, {sum(bool(f.failure) for f in alone)} failed")
    print(f"one process          {one_s:8.1f} s   {1e3 * one_s / count:7.1f} ms a capture")
    print(f"  of which not fits  {one_s - fits_s:8.1f} s   {over_ms:7.2f} ms a capture")
    print(f"{jobs} processes          {many_s:8.1f} s   {1e3 * many_s / count:7.1f} ms a capture")
    print(f"speed-up             {one_s / many_s:8.2f}     load average {os.getloadavg()[0]:.1f}")
    print(f"resumed when done    {again_s:8.1f} s   {1e3 * again_s / count:7.2f} ms a capture")
    print(f"the same digits      {same}")
    busy = os.getloadavg()[0] > 1.5 * jobs
    slow = one_s / many_s < LEAST_SPEED_UP * jobs or over_ms > MOST_PER_CAPTURE_MS
    if busy:
        print("other programs hold the cores: times are shown and not judged")
    return int(not same or (slow and not busy))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
