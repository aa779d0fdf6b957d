"""Foreign binary files are read in a process of its own, with limits on time and memory.

The libraries that read HDF5 and MAT files crash or hang on some damaged ones. There that costs a
child process and one sentence. A child is a program ``SOURCE TARGET MEMORY_BYTES`` that ends in
``serve(main)``; what it found comes back as plain arrays in an NPZ file, which is no pickle.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from motorid.errors import DataError, MotoridError

TIME_LIMIT_S = 60.0
MEMORY_LIMIT = 4 << 30  # bytes of address space
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}  # a buffer for each core would eat the limit
REFUSED = 3  # exit code of a child that says why in a sentence of motorid's own


class ChildFailedError(DataError):
    """The child died, or its library gave up; the message is what is known of why."""


def arrays_from(
    program: str, source: Path, *, time_s: float = TIME_LIMIT_S, memory: int = MEMORY_LIMIT
) -> Mapping[str, Any]:
    """What ``program`` (a file) reads out of ``source``, arrays by name.

    Raises DataError where it refuses or takes too long, ChildFailedError where it fails.
    """
    import tempfile

    import numpy as np

    with tempfile.TemporaryDirectory(prefix="motorid-") as folder:
        target = Path(folder) / "arrays.npz"
        _run(program, source, target, time_s, memory)
        with np.load(target, allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files}


def _run(program: str, source: Path, target: Path, time_s: float, memory: int) -> None:
    import subprocess

    home = str(Path(__file__).parents[2])
    paths = os.pathsep.join([home, *filter(None, [os.environ.get("PYTHONPATH")])])
    try:
        done = subprocess.run(  # noqa: S603  # our own file, by our own interpreter
            [sys.executable, "-P", program, str(source), str(target), str(memory)],
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": paths, "PYTHONIOENCODING": "utf-8"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=time_s,
        )
    except subprocess.TimeoutExpired:
        raise DataError(
            f"{source}: reading it took more than {time_s:g} s and was stopped: "
            "the file is damaged, or too large"
        ) from None
    said = done.stdout.decode("utf-8", "replace").strip()
    if done.returncode == REFUSED:
        raise DataError(said)
    if done.returncode or not target.exists():
        raise ChildFailedError(said or f"the reader ended with code {done.returncode}")


def serve(main: Callable[[str, str], None]) -> None:
    """In the child: runs ``main(SOURCE, TARGET)`` within the memory given, and says what failed."""
    source, target, memory = sys.argv[1:]
    _limit(int(memory))
    try:
        main(source, target)
    except MotoridError as error:
        print(error)
        sys.exit(REFUSED)
    except Exception as error:
        print(f"{type(error).__name__}: {error}".splitlines()[0][:200])
        sys.exit(1)


def _limit(memory: int) -> None:
    """Limits the process's address space, where the system can."""
    if sys.platform != "linux":  # macOS refuses such limits, Windows has none
        return
    import resource

    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    limit = memory if hard == resource.RLIM_INFINITY else min(memory, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
