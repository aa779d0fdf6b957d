"""The simulated board on a pseudo terminal, for another program. POSIX only, real time."""

from __future__ import annotations

import contextlib
import os
import select
import time
from collections.abc import Callable, Iterator

from motorid.errors import LinkError, UsageError
from motorid.sim.device import Device
from motorid.sim.options import parse_url

POLL_S = 1e-3
CHUNK = 4096
LATE_S = 0.02  # a real board has a processor of its own: this one's clock waits for a busy computer
MOST_WAITING = 1 << 20  # bytes kept for a program that does not read; a real line would lose them


def serve(
    url: str,
    announce: Callable[[str], None],
    is_over: Callable[[], bool] = lambda: False,
) -> None:
    """Offer the board of a sim:// URL until Ctrl-C, ``is_over`` or a fault that unplugs it.

    ``announce`` gets the terminal's path when it can be opened. Whatever ``speed`` says, time is
    the wall clock's, less what a busy computer kept this process waiting. Raises UsageError where
    there are no pseudo terminals.
    """
    offer(Device(parse_url(url)), announce, is_over)


def offer(
    device: Device, announce: Callable[[str], None], is_over: Callable[[], bool] = lambda: False
) -> None:
    """The same of any board that hears, says and lets time pass as ``Device`` does."""
    with _terminal() as (master, path):
        announce(path)
        with contextlib.suppress(KeyboardInterrupt, LinkError):
            _pump(device, master, is_over)


@contextlib.contextmanager
def _terminal() -> Iterator[tuple[int, str]]:
    """A raw pseudo terminal: our end's descriptor, and the path of the other."""
    try:
        import tty
    except ImportError:
        raise UsageError("motorid sim --pty needs Linux or macOS") from None
    master, slave = os.openpty()
    try:
        tty.setraw(slave)
        os.set_blocking(master, False)
        # the slave stays open here, so that a client may come, go and come again
        yield master, os.ttyname(slave)
    finally:
        os.close(slave)
        os.close(master)


def _pump(device: Device, master: int, is_over: Callable[[], bool]) -> None:
    """Between two looks at what has come, time moves by a little at most.

    Else a computer too busy for this process would make the board miss heartbeats that came.
    """
    before = time.monotonic()
    waiting, at = b"", device.now
    while not is_over():
        select.select([master], [master] if waiting else [], [], POLL_S)
        device.hear(_read(master))
        now = time.monotonic()
        at += min(now - before, LATE_S)
        before = now
        device.advance_to(at)
        device.check()
        waiting = _write(master, (waiting + device.take(CHUNK))[-MOST_WAITING:])


def _read(master: int) -> bytes:
    try:
        return os.read(master, CHUNK)
    except BlockingIOError:
        return b""


def _write(master: int, data: bytes) -> bytes:
    """What could not be written yet."""
    try:
        return data[os.write(master, data) :] if data else data
    except BlockingIOError:
        return data
