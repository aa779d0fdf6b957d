"""Foreign binary files are read in a process of its own, with limits on work and memory.

The libraries that read HDF5 and MAT files crash or hang on some damaged ones. There that costs a
child process and one sentence. A child is a program ``SOURCE TARGET MEMORY CPU_S`` that ends in
``serve(main, libraries)``; what it found comes back as plain arrays in an NPZ file, which is no
pickle. Where the system forks, a warm child forks one for each file.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from motorid.capture.warm_child import FORKS, GoneError, WarmChild, serve_files
from motorid.errors import DataError, MotoridError
from motorid.limits import Limits, cpu_s, refuse_large

PATIENCE_S = 600.0  # for a disk or a library that waits; work is bounded by the processor's time
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}  # a buffer for each core would eat the limit
OUT_OF_TIME = (-24, 152)  # SIGXCPU, as a signal and as a shell reports it
REFUSED = 3  # exit code of a child that says why in a sentence of motorid's own


class Bounds(NamedTuple):
    """What a child may take beyond what its libraries did."""

    memory: int  # bytes
    cpu_s: int  # seconds of the processor


class ChildFailedError(DataError):
    """The child died, or its library gave up; the message is what is known of why."""


def arrays_from(
    program: str, source: Path, limits: Limits, *, patience_s: float | None = None
) -> Mapping[str, Any]:
    """What ``program`` (a file) reads out of ``source`` within ``limits``, arrays by name.

    Raises DataError where it refuses or takes too long, ChildFailedError where it fails.
    """
    refuse_large(source, limits)
    bounds = Bounds(limits.memory or 0, cpu_s(limits, source.stat().st_size))
    import tempfile

    import numpy as np

    with tempfile.TemporaryDirectory(prefix="motorid-") as folder:
        target = Path(folder) / "arrays.npz"
        _run(program, source, target, bounds, PATIENCE_S if patience_s is None else patience_s)
        with np.load(target, allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files}


def _run(program: str, source: Path, target: Path, bounds: Bounds, patience_s: float) -> None:
    from subprocess import TimeoutExpired

    try:
        code, said = _read_warm(program, source, target, bounds, patience_s)
    except (TimeoutError, TimeoutExpired):
        raise DataError(
            f"{source}: reading it took more than {patience_s:g} s and was stopped: "
            "the file is damaged, or too large"
        ) from None
    if code in OUT_OF_TIME:
        raise DataError(
            f"{source}: reading it took more than {bounds.cpu_s:g} s of the processor and was "
            "stopped: the file is damaged"
        )
    if code == REFUSED:
        raise DataError(said if said.startswith(str(source)) else f"{source}: {said}")
    if code or not target.exists():
        raise ChildFailedError(said or f"the reader ended with code {code}")


_warm: dict[str, WarmChild] = {}  # by program


def _read_warm(
    program: str, source: Path, target: Path, bounds: Bounds, patience_s: float
) -> tuple[int, str]:
    """Exit code of the child that read ``source``, and what it said.

    One that a signal ended is tried again without a fork: some systems' libraries do not bear it.
    """
    if not FORKS:
        return _read_alone(program, source, target, bounds, patience_s)
    known = _warm.get(program)
    if known is None or known.owner != os.getpid():
        known = _warm[program] = WarmChild(program, _environment())
    try:
        code, said = known.read(str(source), str(target), list(bounds), patience_s)
    except TimeoutError:
        _warm.pop(program, None)
        raise
    except GoneError:
        _warm.pop(program, None)
        code = -1
    if code < 0 and code not in OUT_OF_TIME:
        return _read_alone(program, source, target, bounds, patience_s)
    return code, said


def _read_alone(
    program: str, source: Path, target: Path, bounds: Bounds, patience_s: float
) -> tuple[int, str]:
    """The same by a child that is started for this file."""
    import subprocess

    done = subprocess.run(  # noqa: S603  # our own file, by our own interpreter
        [sys.executable, "-P", program, str(source), str(target), *map(str, bounds)],
        env=_environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=patience_s,
    )
    return done.returncode, done.stdout.decode("utf-8", "replace").strip()


def _environment() -> dict[str, str]:
    home = str(Path(__file__).parents[2])
    paths = os.pathsep.join([home, *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, **ONE_THREAD, "PYTHONPATH": paths, "PYTHONIOENCODING": "utf-8"}


def serve(main: Callable[[str, str], None], libraries: Sequence[str]) -> None:
    """In the child: runs ``main(SOURCE, TARGET)`` within the memory given, and says what failed.

    It loads ``libraries`` first. Without arguments it is a warm child.
    """
    for name in libraries:
        import_module(name)
    if len(sys.argv) > 1:
        source, target, *bounds = sys.argv[1:]
        sys.exit(_read_one(main, source, target, [int(one) for one in bounds]))
    serve_files(partial(_read_one, main))


def _read_one(
    main: Callable[[str, str], None], source: str, target: str, bounds: Sequence[int]
) -> int:
    _limit(Bounds(*bounds))
    try:
        main(source, target)
    except MotoridError as error:
        print(error)
        return REFUSED
    except Exception as error:
        print(f"{type(error).__name__}: {error}".splitlines()[0][:200])
        return 1
    return 0


def _limit(bounds: Bounds) -> None:
    """Limits what the process may take from here on, where the system can."""
    if sys.platform != "linux":  # macOS refuses such limits, Windows has none
        return
    import resource

    spent = resource.getrusage(resource.RUSAGE_SELF)
    limits = {
        resource.RLIMIT_AS: _address_space() + bounds.memory,
        resource.RLIMIT_CORE: 0,
        resource.RLIMIT_CPU: math.ceil(spent.ru_utime + spent.ru_stime) + bounds.cpu_s,
    }
    for which, most in limits.items():
        hard = resource.getrlimit(which)[1]
        limit = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(which, (limit, hard))


def _address_space() -> int:
    """Bytes that the process has mapped already: the interpreter and its libraries."""
    with open("/proc/self/statm", "rb") as file:
        return int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
