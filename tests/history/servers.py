"""A PostgreSQL of the tests' own, on a socket in a temporary folder, which can be killed."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import create_engine
from sqlalchemy.engine import make_url


def programs() -> Path:
    """The folder of initdb and pg_ctl; skips where there is none."""
    if sys.platform == "win32":
        pytest.skip("no PostgreSQL server on this machine that the test can start")
    pytest.importorskip("psycopg", reason="no psycopg: pip install 'motorid[postgresql]'")
    found = shutil.which("initdb")
    usual = sorted(Path("/usr/lib/postgresql").glob("*/bin"))
    folders = [Path(found).resolve().parent] if found else usual
    if not folders:
        pytest.skip("no PostgreSQL server on this machine")
    return folders[-1]


class Server:
    """Its data in ``folder``, which it owns."""

    def __init__(self, folder: Path, settings: str = "") -> None:
        self.folder, self.where, self.settings = folder, programs(), settings
        self.as_user: dict[str, Any] = {}
        if os.getuid() == 0:  # the server refuses to run as root
            import pwd

            try:
                owner = pwd.getpwnam("postgres")
            except KeyError:
                pytest.skip("no PostgreSQL server on this machine that root may start")
            os.chown(folder, owner.pw_uid, owner.pw_gid)
            self.as_user = {"user": owner.pw_uid, "group": owner.pw_gid}
        self._run("initdb", "-D", f"{folder}/data", "-U", "motorid", "-A", "trust", "-N")

    def _run(self, program: str, *words: str) -> None:
        command = [str(self.where / program), *words]
        subprocess.run(command, check=True, capture_output=True, cwd="/", **self.as_user)

    def start(self) -> None:
        """Comes back once it answers, recovered if it was killed."""
        settings = f"-k {self.folder} -c listen_addresses='' -c fsync=off {self.settings}"
        self._run(
            "pg_ctl", "-D", f"{self.folder}/data", "-w", "-l", f"{self.folder}/log",
            "-o", settings, "start",
        )  # fmt: skip

    @property
    def runs(self) -> bool:
        """Whether it does."""
        asked = [str(self.where / "pg_ctl"), "-D", f"{self.folder}/data", "status"]
        done = subprocess.run(asked, capture_output=True, check=False, cwd="/", **self.as_user)
        return done.returncode == 0

    def kill(self) -> None:
        """The whole server at once, as a power failure of its process would."""
        first = int((self.folder / "data" / "postmaster.pid").read_text().split()[0])
        os.kill(first, signal.SIGKILL)

    def stop(self) -> None:
        """Ends it, whatever it does."""
        if self.runs:
            self._run("pg_ctl", "-D", f"{self.folder}/data", "-w", "-m", "immediate", "stop")

    def copy(self, name: str, into: str) -> None:
        """Backs up a database as its owner would, and restores it into another."""
        dumped = f"{self.folder}/{name}.dump"
        reached = ("-h", str(self.folder), "-U", "motorid")
        self._run("pg_dump", *reached, "-Fc", "-f", dumped, name)
        self.database(into)
        self._run("pg_restore", *reached, "-d", into, "--exit-on-error", dumped)

    @property
    def url(self) -> str:
        """Of its first database."""
        return f"postgresql+psycopg://motorid@/postgres?host={self.folder}"

    def database(self, name: str) -> str:
        """Makes an empty database; its URL."""
        engine = create_engine(self.url, isolation_level="AUTOCOMMIT")
        with engine.connect() as connection:
            connection.exec_driver_sql(f"CREATE DATABASE {name}")
        engine.dispose()
        return make_url(self.url).set(database=name).render_as_string(hide_password=False)


@contextmanager
def running(folder: str | None = None, settings: str = "") -> Iterator[Server]:
    """A server that runs, in ``folder`` or a temporary one."""
    programs()
    with tempfile.TemporaryDirectory(prefix="motorid-pg-", dir=folder) as made:
        server = Server(Path(made), settings)
        server.start()
        try:
            yield server
        finally:
            server.stop()
