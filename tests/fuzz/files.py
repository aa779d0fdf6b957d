"""HDF5 captures and MAT files with changed bytes, read as a user's file is: by a limited child.

The children are forked from a warm one, so that hundreds can be had in a minute. Linux and macOS.
"""

from __future__ import annotations

import contextlib
import io
import random
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
import scipy.io

from motorid.capture import child, store
from motorid.capture.mat_reader import MatSource
from motorid.errors import DataError
from tests.exact_capture import FAULHABER, Plan, clean_capture
from tests.fuzz.sentence import check_sentence

HANG_S = 5.0  # in place of a user's minute
MEMORY = 1 << 30
LONGEST_WAIT_S = HANG_S + 30.0  # its killing and a new child, on a busy machine
RUN = child._run


def read_capture(path: Path) -> None:
    """Raises DataError."""
    capture = store.load(path)
    assert np.all(np.diff(capture.ticks) > 0)
    assert all(len(channel.raw) == len(capture) for channel in capture.channels.values())


def read_mat(path: Path) -> None:
    """Raises DataError."""
    source = MatSource(path)
    for name in list(source.names)[:3]:
        with contextlib.suppress(DataError):  # two columns of different length
            source.read([name])


READERS: dict[str, Callable[[Path], None]] = {"hdf5": read_capture, "mat": read_mat}


def seeds(target: str) -> list[bytes]:
    """Small files that are right."""
    if target == "hdf5":
        return [store.to_bytes(clean_capture(FAULHABER, Plan(count=200)))]
    columns = {"t": np.arange(50.0), "i": np.ones((50, 2)), "log": {"x": np.arange(3.0)}}
    found = []
    for more in ({}, {"do_compression": True}):
        file = io.BytesIO()
        scipy.io.savemat(file, columns, **more)
        found.append(file.getvalue())
    with h5py.File(io.BytesIO(), "w") as h5:
        h5["t"], h5["g/i"] = columns["t"], columns["i"]
        h5.flush()
        found.append(bytes(h5.id.get_file_image()))
    return found


def changed(data: bytes, rng: random.Random) -> bytes:
    """A copy with a few bytes changed, zeroed, raised, moved, or its end cut off."""
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4, 16))):
        at = rng.randrange(len(out))
        match rng.randrange(6):
            case 0:
                out[at] ^= 1 << rng.randrange(8)
            case 1:
                out[at] = rng.randrange(256)
            case 2:
                out[at : at + 8] = rng.choice((bytes(8), b"\xff" * 8, b"\xff" * 7 + b"\x7f"))
            case 3:
                other = rng.randrange(len(out))
                out[at : at + 16] = out[other : other + 16]
            case 4:
                out[at : at + 4] = rng.randrange(1 << 32).to_bytes(4, "little")
            case 5 if rng.random() < 0.2:
                del out[max(1, at) :]
    return bytes(out)


def limited(
    program: str, source: Path, target: Path, bounds: child.Bounds, patience_s: float
) -> None:
    """``child._run`` with less time and memory than a user's file is given."""
    RUN(program, source, target, child.Bounds(MEMORY, int(HANG_S)), HANG_S)


def _inputs(target: str, seed: int) -> Iterator[bytes]:
    whole, rng = seeds(target), random.Random(seed)
    yield from whole
    while True:
        yield changed(rng.choice(whole), rng)


def fuzz(target: str, seconds: float, runs: int, seed: int, folder: Path) -> int:
    """Reads changed files for a while; 1 when one got past the child. Prints what became of them.

    The last input is in ``folder`` when it broke something.
    """
    seen: Counter[str] = Counter()
    path = folder / f"last.{'mat' if target == 'mat' else 'h5'}"
    with mock.patch.object(child, "_run", limited), tempfile.TemporaryDirectory() as scratch:
        tempfile.tempdir = scratch
        path.write_bytes(seeds(target)[0])
        READERS[target](path)  # the warm child loads its libraries
        until = time.monotonic() + seconds
        for number, data in enumerate(_inputs(target, seed)):
            if number == runs or time.monotonic() > until:
                break
            path.write_bytes(data)
            began = time.monotonic()
            seen[_outcome(target, path, len(data))] += 1
            if time.monotonic() - began > LONGEST_WAIT_S:
                print(f"input {number} held the reader up: {path}", file=sys.stderr)
                return 1
        tempfile.tempdir = None
    print(f"Done {sum(seen.values())} runs: {dict(sorted(seen.items()))}", file=sys.stderr)
    return 0


def _outcome(target: str, path: Path, size: int) -> str:
    """In a word. Raises whatever is no DataError: the reader's promise is broken."""
    try:
        READERS[target](path)
    except DataError as error:
        check_sentence(str(error), size)
        if "and was stopped" in str(error):
            return "hung, stopped"
        return "died" if "ended with code" in str(error) else "refused"
    return "read"
