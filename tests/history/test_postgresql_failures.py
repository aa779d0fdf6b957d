"""A server that is killed, drops its clients or runs out of disk: nothing is lost or doubled.

Twenty writers add their motors, and each tries again until it is told that a motor is safe, as the
stations' workers do.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest
from sqlalchemy import create_engine

from motorid.errors import DataError
from motorid.quality.history import open_history
from tests.history.records import record
from tests.history.servers import Server, running

pytestmark = [pytest.mark.slow, pytest.mark.long]
WRITERS, EACH = 20, 10
PATIENCE_S = 240.0


class Writers:
    """They write until all is safe; ``failed`` counts the sentences that they were told."""

    def __init__(self, place: str) -> None:
        self.place = place
        self.safe: list[int] = []
        self.failed = 0
        self.until = time.monotonic() + PATIENCE_S
        with open_history(place):
            pass  # the tables are there
        self.pool = ThreadPoolExecutor(WRITERS)
        self.done = [self.pool.submit(self._write, one) for one in range(WRITERS)]

    def _write(self, writer: int) -> None:
        with open_history(self.place, create=False) as history:
            for number in range(writer * EACH, (writer + 1) * EACH):
                self._until_safe(lambda number=number: history.add(self._record(number)))
                self.safe.append(number)

    @staticmethod
    def _record(number: int) -> object:
        return record(number, station=f"line-{number % 5}")

    def _until_safe(self, add: Callable[[], object]) -> None:
        while True:
            try:
                add()
            except DataError:
                self.failed += 1
                assert time.monotonic() < self.until, "the server does not come back"
                time.sleep(0.05)
            else:
                return

    def wait_for(self, count: int) -> None:
        """Until so many motors are safe."""
        while len(self.safe) < count:
            assert time.monotonic() < self.until
            for one in self.done:
                if one.done():
                    one.result()
            time.sleep(0.005)

    def finish(self) -> None:
        """All are safe, once each, and each seal holds."""
        for one in self.done:
            one.result(PATIENCE_S)
        with open_history(self.place) as history:
            serials = sorted(row.serial for row in history.results())
            assert serials == [f"SN-{n:05d}" for n in range(WRITERS * EACH)]
            found = history.verify()
            assert (found.sealed, found.problems) == (WRITERS * EACH, ())


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    """One for the tests that leave it running."""
    with running() as found:
        yield found


def test_a_server_that_is_killed_in_mid_write(server: Server) -> None:
    """And comes back, twice: what was said to be safe is."""
    writers = Writers(server.database("killed"))
    for share in (0.2, 0.6):
        writers.wait_for(int(share * WRITERS * EACH))
        safe = set(writers.safe)
        server.kill()
        while server.runs:
            time.sleep(0.05)
        _start(server)
        with open_history(writers.place) as history:
            kept = {int(row.serial[3:]) for row in history.results()}
        assert safe <= kept
    writers.finish()
    assert writers.failed


def _start(server: Server) -> None:
    """Its old processes may hold the memory for a moment longer."""
    until = time.monotonic() + PATIENCE_S
    while True:
        try:
            server.start()
        except subprocess.CalledProcessError:
            assert time.monotonic() < until, (server.folder / "log").read_text()[-2000:]
            time.sleep(0.2)
        else:
            return


def test_clients_that_are_cut_off_write_on(server: Server) -> None:
    """Every connection is ended, again and again, while they write."""
    cut = (
        "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity "
        "WHERE datname = 'cut' AND pid <> pg_backend_pid()"
    )
    writers = Writers(server.database("cut"))
    engine = create_engine(server.url, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        for share in (0.1, 0.3, 0.5, 0.7, 0.9):
            writers.wait_for(int(share * WRITERS * EACH))
            connection.exec_driver_sql(cut)
    engine.dispose()
    writers.finish()
    assert writers.failed


@contextmanager
def small_disk(megabytes: int) -> Iterator[Path]:
    """A file system of that size; skips where this user may not make one."""
    with tempfile.TemporaryDirectory(prefix="motorid-disk-") as at:
        command = ["mount", "-t", "tmpfs", "-o", f"size={megabytes}m,mode=755", "tmpfs", at]
        if sys.platform != "linux" or subprocess.run(command, check=False).returncode:
            pytest.skip("no PostgreSQL on a small disk: this user may not mount one")
        try:
            os.chmod(at, 0o755)
            yield Path(at)
        finally:
            subprocess.run(["umount", "-l", at], check=True)


def test_a_disk_that_fills_up() -> None:
    """Writers are told so, what is safe stays so, and all goes on once there is room."""
    with small_disk(160) as disk, running(str(disk)) as server:
        place, ballast = server.database("full_disk"), disk / "ballast"
        free = shutil.disk_usage(disk).free
        with ballast.open("wb") as file:  # the rest is then full before the writers are done
            os.posix_fallocate(file.fileno(), 0, free - (24 << 20))
        writers = Writers(place)
        writers.wait_for(20)
        _fill(ballast)
        before = writers.failed
        while writers.failed < before + WRITERS:
            assert time.monotonic() < writers.until
            assert not all(one.done() for one in writers.done), "the disk was never full"
            time.sleep(0.02)
        safe = set(writers.safe)
        ballast.unlink()
        if not server.runs:
            _start(server)
        with open_history(writers.place) as history:
            assert safe <= {int(row.serial[3:]) for row in history.results()}
        writers.finish()


def _fill(path: Path) -> None:
    """Until nothing more fits; for a moment others may be faster."""
    with path.open("ab", buffering=0) as file:
        for size in (1 << 20, 1 << 12):
            for _ in range(1 << 16):
                try:
                    file.write(bytes(size))
                except OSError:
                    break
