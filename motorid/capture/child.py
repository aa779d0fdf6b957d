"""Foreign binary files are read in a process of its own, with limits on time and memory.

The libraries that read HDF5 and MAT files crash or hang on some damaged ones. There that costs a
child process and one sentence. A child is a program ``SOURCE TARGET MEMORY_BYTES`` that ends in
``serve(main, libraries)``; what it found comes back as plain arrays in an NPZ file, which is no
pickle. Where the system forks, a warm child forks one for each file.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from motorid.capture.warm_child import FORKS, GoneError, WarmChild, serve_files
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
    from subprocess import TimeoutExpired

    try:
        code, said = _read_warm(program, source, target, time_s, memory)
    except (TimeoutError, TimeoutExpired):
        raise DataError(
            f"{source}: reading it took more than {time_s:g} s and was stopped: "
            "the file is damaged, or too large"
        ) from None
    if code == REFUSED:
        raise DataError(said)
    if code or not target.exists():
        raise ChildFailedError(said or f"the reader ended with code {code}")


_warm: dict[str, WarmChild] = {}  # by program


def _read_warm(
    program: str, source: Path, target: Path, time_s: float, memory: int
) -> tuple[int, str]:
    """Exit code of the child that read ``source``, and what it said.

    One that a signal ended is tried again without a fork: some systems' libraries do not bear it.
    """
    if not FORKS:
        return _read_alone(program, source, target, time_s, memory)
    known = _warm.get(program)
    if known is None or known.owner != os.getpid():
        known = _warm[program] = WarmChild(program, _environment())
    try:
        code, said = known.read(str(source), str(target), memory, time_s)
    except TimeoutError:
        _warm.pop(program, None)
        raise
    except GoneError:
        _warm.pop(program, None)
        code = -1
    if code < 0:
        return _read_alone(program, source, target, time_s, memory)
    return code, said


def _read_alone(
    program: str, source: Path, target: Path, time_s: float, memory: int
) -> tuple[int, str]:
    """The same by a child that is started for this file."""
    import subprocess

    done = subprocess.run(  # noqa: S603  # our own file, by our own interpreter
        [sys.executable, "-P", program, str(source), str(target), str(memory)],
        env=_environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=time_s,
    )
    return done.returncode, done.stdout.decode("utf-8", "replace").strip()


def _environment() -> dict[str, str]:
    home = str(Path(__file__).parents[2])
    paths = os.pathsep.join([home, *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, **ONE_THREAD, "PYTHONPATH": paths, "PYTHONIOENCODING": "utf-8"}


def serve(main: Callable[[str, str], None], libraries: Sequence[str]) -> None:
    """In the child: runs ``main(SOURCE, TARGET)`` within the memory given, and says what failed.

    Without arguments it is a warm child, and loads ``libraries`` before the first file comes.
    """
    if len(sys.argv) > 1:
        source, target, memory = sys.argv[1:]
        sys.exit(_read_one(main, source, target, int(memory)))
    for name in libraries:
        import_module(name)
    serve_files(partial(_read_one, main))


def _read_one(main: Callable[[str, str], None], source: str, target: str, memory: int) -> int:
    _limit(memory)
    try:
        main(source, target)
    except MotoridError as error:
        print(error)
        return REFUSED
    except Exception as error:
        print(f"{type(error).__name__}: {error}".splitlines()[0][:200])
        return 1
    return 0


def _limit(memory: int) -> None:
    """Limits the process's address space, where the system can, and its life if it is orphaned."""
    if sys.platform != "linux":  # macOS refuses such limits, Windows has none
        return
    import resource

    limits = {
        resource.RLIMIT_AS: memory,
        resource.RLIMIT_CORE: 0,
        # of the processor: more than who waits for it would wait
        resource.RLIMIT_CPU: int(TIME_LIMIT_S) + 1,
    }
    for which, most in limits.items():
        hard = resource.getrlimit(which)[1]
        limit = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(which, (limit, limit))
