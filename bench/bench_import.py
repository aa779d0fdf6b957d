"""Imports of large files: seconds and memory against targets, and what is refused, how soon.

    python bench/bench_import.py --rows 2000000 --refused

Each import is a process of its own, started as a person starts it. Seconds are of the processor
and of the clock; memory is the largest resident set of it and of its children. Targets: 2 million
rows in 10 s and 5 times the file's size; 10 million in 60 s; a refusal in 30 s and 1 GiB.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

SMALL = 1 << 20  # rows beyond which the memory of the libraries counts for little
TARGET_S = {2_000_000: 10.0, 10_000_000: 60.0}
MEMORY_FACTOR = 5.0  # of the file's size
REFUSED_S, REFUSED_MB = 30.0, 1024.0
MAPS = ("time=t:s", "current=i:A", "voltage=u:V", "speed=n:rpm")
CHILD = """
import json, resource, sys, time
began = time.perf_counter()
from motorid.cli.main import run
code = run(sys.argv[1:])
from motorid.capture import child
for one in list(child._warm.values()):
    one.stop()  # so that it is counted
own, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
cpu_s = sum(one.ru_utime + one.ru_stime for one in (own, others))
print(json.dumps({"code": code, "cpu_s": cpu_s, "wall_s": time.perf_counter() - began,
                  "mb": max(own.ru_maxrss, others.ru_maxrss) / 1024}))
"""


@dataclass(frozen=True)
class Took:
    """What an import took, and what it said."""

    code: int
    cpu_s: float
    wall_s: float
    mb: float
    said: str


def run(*arguments: str) -> Took:
    """One command in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", CHILD, *arguments], capture_output=True, text=True, check=True
    )
    return Took(**json.loads(done.stdout.splitlines()[-1]), said=done.stderr.strip())


def table(path: Path, rows: int) -> None:
    """A log of so many rows, as a data logger writes it."""
    rng = np.random.default_rng(1)
    with path.open("w") as file:
        file.write("t,i,u,n\n")
        for begin in range(0, rows, 20_000):
            count = min(20_000, rows - begin)
            t = (begin + np.arange(count)) * 1e-4
            cells = zip(
                t,
                rng.normal(1, 0.1, count),
                rng.normal(12, 0.1, count),
                rng.normal(3e3, 9, count),
                strict=True,
            )
            file.writelines(f"{a:.4f},{b:.4f},{c:.4f},{d:.2f}\n" for a, b, c, d in cells)


def imported(rows: int, folder: Path) -> bool:
    """Imports a table of so many rows; prints a row, and says whether the targets were met."""
    path, target = folder / "log.csv", folder / "log.h5"
    table(path, rows)  # in small pieces: what this process takes would count as its children's
    maps = [part for one in MAPS for part in ("--map", one)]
    took = run("import", str(path), *maps, "-o", str(target))
    assert took.code == 0, took.said
    mb = path.stat().st_size / 2**20
    factor = took.mb / mb
    goal_s = next((s for most, s in TARGET_S.items() if rows <= most), np.inf)
    met = took.wall_s <= goal_s and (rows < SMALL or factor <= MEMORY_FACTOR)
    print(
        f"| {rows:,} rows | {mb:.0f} MiB | {took.cpu_s:.1f} s | {took.wall_s:.1f} s | "
        f"{took.mb:.0f} MiB | {factor:.1f} | {'met' if met else 'MISSED'} |",
        flush=True,
    )
    path.unlink()
    target.unlink()
    return met


def wide(folder: Path) -> Path:
    """A million columns."""
    path = folder / "wide.csv"
    path.write_text(("1," * 999_999 + "1\n") * 3)
    return path


def sparse(folder: Path) -> Path:
    """Two gigabytes of nothing."""
    path = folder / "sparse.csv"
    with path.open("wb") as file:
        file.write(b"t,i\n0,1\n")
        file.truncate(2 << 30)
    return path


def one_line(folder: Path) -> Path:
    """A single line of a gigabyte, which is within the size of a table."""
    path = folder / "line.csv"
    with path.open("wb") as file:
        for _ in range(1000):
            file.write(b"1.5," * 250_000)
    return path


def many_rows(folder: Path) -> Path:
    """Eleven million short rows."""
    path = folder / "rows.csv"
    with path.open("wb") as file:
        for _ in range(110):
            file.write(b"1,2\n" * 100_000)
    return path


def mat_rows(folder: Path) -> Path:
    """A MAT file of 20 million rows."""
    import scipy.io

    path = folder / "rows.mat"
    scipy.io.savemat(path, {"t": np.arange(20_000_000.0), "i": np.ones(20_000_000)})
    return path


def mat_bomb(folder: Path) -> Path:
    """A compressed struct that unfolds to a gigabyte and a half."""
    import scipy.io

    path = folder / "bomb.mat"
    scipy.io.savemat(path, {"s": {"t": np.zeros(200_000_000)}}, do_compression=True)
    return path


def absurd(folder: Path) -> Path:
    """A MAT file of version 7.3 that declares 10^13 rows and holds none."""
    import h5py

    path = folder / "absurd.mat"
    with h5py.File(path, "w") as file:
        file.create_dataset("t", (10**13,), "f8", chunks=(1 << 20,))
    return path


REFUSED: dict[str, Callable[[Path], Path]] = {
    "10^6 columns": wide,
    "2 GiB, sparse": sparse,
    "a line of 1 GB": one_line,
    "11 million rows": many_rows,
    "MAT, 20 million rows": mat_rows,
    "MAT, compressed 1.6 GB": mat_bomb,
    "MAT, 10^13 rows declared": absurd,
}


def refused(name: str, folder: Path) -> bool:
    """Tries to import a file beyond the limits; prints a row, and whether the targets were met."""
    # by another process: the largest memory of this one would count as that of its children
    make = subprocess.run([sys.executable, __file__, "--make", name, str(folder)],
                          capture_output=True, text=True, check=True)  # fmt: skip
    path = Path(make.stdout.strip())
    took = run("import", str(path), "--map", "time=t:s", "--map", "current=i:A", "-o",
               str(folder / "out.h5"))  # fmt: skip
    path.unlink()
    met = took.code == 4 and took.wall_s <= REFUSED_S and took.mb <= REFUSED_MB
    print(
        f"| {name} | {took.cpu_s:.1f} s | {took.wall_s:.1f} s | {took.mb:.0f} MiB | exit "
        f"{took.code} | {'met' if met else 'MISSED'} |",
        flush=True,
    )
    print(f"    {took.said.replace(str(folder), '')}", file=sys.stderr)
    return met


def main() -> None:
    """Prints both tables; ends with 1 where a target was missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, nargs="*", default=[2_000_000, 10_000_000])
    parser.add_argument("--refused", nargs="*", choices=list(REFUSED), default=list(REFUSED))
    parser.add_argument("--make", nargs=2, metavar=("NAME", "FOLDER"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.make:
        print(REFUSED[options.make[0]](Path(options.make[1])))
        return
    met = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        print("| import | file | processor | clock | memory | times the file | target |")
        print("|---|---|---|---|---|---|---|")
        met += [imported(rows, folder) for rows in options.rows]
        print("\n| refused | processor | clock | memory | ends with | target |")
        print("|---|---|---|---|---|---|")
        met += [refused(name, folder) for name in options.refused]
    sys.exit(0 if all(met) else 1)


if __name__ == "__main__":
    main()
