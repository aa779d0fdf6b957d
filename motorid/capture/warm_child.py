"""A child with its libraries loaded, that forks a child of its own for each file it is to read.

Loading the libraries costs ten times as much as reading a capture. Every file has a process to
itself all the same, with its limits, and whatever becomes of that one costs one file. Only where
the system forks (not on Windows).
"""

from __future__ import annotations

import atexit
import contextlib
import os
import select
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import IO, Any

FORKS = hasattr(os, "fork")
SAID = ".said"  # beside the target: what the child of a file wrote to its standard output
PARTING_S = 1.0


class GoneError(Exception):
    """The warm child itself died or never began: nothing is known of the file."""


class WarmChild:
    """One program (a file that ends in ``child.serve``), started at the first file."""

    def __init__(self, program: str, environment: dict[str, str]) -> None:
        self.owner = os.getpid()  # a process that is forked from this one needs a child of its own
        self._lock = threading.Lock()
        self._process = subprocess.Popen(  # noqa: S603  # our own file, by our own interpreter
            [sys.executable, "-P", program],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            process_group=0,  # so that it can be ended with the child that it waits for
        )
        atexit.register(self.stop)

    def read(self, source: str, target: str, bounds: list[int], time_s: float) -> tuple[int, str]:
        """Exit code of the child that read ``source``, and what it said.

        Raises TimeoutError, GoneError; of no further use is a warm child after either.
        """
        names = [os.fsencode(name).hex() for name in (source, target)]
        order = " ".join([*names, *map(str, bounds)]) + "\n"
        with self._lock:
            try:
                code = self._ask(order.encode(), time_s)
            except TimeoutError:  # an OSError too
                self.stop()
                raise
            except (OSError, ValueError) as error:
                self.stop()
                raise GoneError(str(error)) from None
        with open(target + SAID, "rb") as said:
            return code, said.read().decode("utf-8", "replace").strip()

    def _ask(self, order: bytes, time_s: float) -> int:
        orders, answers = self._pipes()
        orders.write(order)
        orders.flush()
        if not select.select([answers], [], [], time_s)[0]:
            raise TimeoutError
        return int(answers.readline())  # nothing, which is no number, when it is gone

    def _pipes(self) -> tuple[IO[bytes], IO[bytes]]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        return self._process.stdin, self._process.stdout

    def stop(self) -> None:
        """Ends it, and the child that it may be waiting for."""
        atexit.unregister(self.stop)
        if self.owner != os.getpid():
            return
        with contextlib.suppress(OSError):
            os.killpg(self._process.pid, 9)
        for pipe in self._pipes():
            with contextlib.suppress(OSError):
                pipe.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(PARTING_S)


def serve_files(read_one: Callable[[str, str, list[int]], int]) -> None:
    """In the warm child: forks for each order on the standard input, and answers its exit code.

    ``read_one`` reads a source into a target within bounds and gives the exit code.
    """
    for line in sys.stdin.buffer:
        source, target, *bounds = line.split()
        pid = os.fork()
        if not pid:
            names = [os.fsdecode(bytes.fromhex(name.decode())) for name in (source, target)]
            _be_child(read_one, *names, [int(bound) for bound in bounds])
        _, status = os.waitpid(pid, 0)
        sys.stdout.buffer.write(b"%d\n" % os.waitstatus_to_exitcode(status))
        sys.stdout.buffer.flush()


def _be_child(read_one: Callable[[str, str, list[int]], int], *order: Any) -> None:
    code = 1
    try:
        said = os.open(order[1] + SAID, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        os.dup2(said, sys.stdout.fileno())
        code = read_one(*order)
        sys.stdout.flush()
    finally:
        os._exit(code)
