"""What all stations share, and what can fail: each can be killed and started again."""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import subprocess
import time
from pathlib import Path
from typing import Any, Protocol

from tests.plant.mosquitto import Mosquitto

PATIENCE_S = 120.0


class Service(Protocol):
    """A database, a broker; a store would be another."""

    name: str

    def start(self) -> None:
        """It answers when this returns."""

    def fail(self) -> None:
        """It dies, with what it holds in memory alone."""


class Database:
    """PostgreSQL of our own, on a socket in ``folder``."""

    name = "database"

    def __init__(self, folder: Path) -> None:
        found = shutil.which("initdb")
        places = sorted(Path("/usr/lib/postgresql").glob("*/bin"))
        self.programs = Path(found).parent if found else places[-1]
        self.folder, self.data = folder, folder / "data"
        self.as_user: dict[str, Any] = {}
        folder.mkdir()
        if os.getuid() == 0:  # the server refuses to run as root
            owner = pwd.getpwnam("postgres")
            os.chown(folder, owner.pw_uid, owner.pw_gid)
            self.as_user = {"user": owner.pw_uid, "group": owner.pw_gid}
        self._run("initdb", "-D", str(self.data), "-U", "motorid", "-A", "trust")

    @property
    def url(self) -> str:
        """For SQLAlchemy."""
        return f"postgresql+psycopg://motorid@/postgres?host={self.folder}"

    def start(self) -> None:
        """Tries until those of before have ended: after a kill they still hold its memory."""
        until = time.monotonic() + PATIENCE_S
        while True:
            try:
                settings = f"-k {self.folder} -c listen_addresses='' -c max_connections=200"
                self._run("pg_ctl", "-D", str(self.data), "-w", "-l", str(self.folder / "log"),
                          "-o", settings, "start")  # fmt: skip
            except subprocess.CalledProcessError:
                if time.monotonic() > until:
                    raise
                time.sleep(0.5)
            else:
                return

    def fail(self) -> None:
        """SIGKILL to the server itself."""
        first = (self.data / "postmaster.pid").read_text().split()[0]
        os.kill(int(first), signal.SIGKILL)

    def stop(self) -> None:
        """At the end."""
        self._run("pg_ctl", "-D", str(self.data), "-m", "immediate", "stop")

    def _run(self, program: str, *words: str) -> None:
        call = [str(self.programs / program), *words]
        subprocess.run(
            call, check=True, cwd="/", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            **self.as_user,
        )  # fmt: skip


class Broker(Mosquitto):
    """Debian's mosquitto as it comes: it drops what it queues beyond 1,000."""

    name = "broker"

    def fail(self) -> None:
        """SIGKILL: its queues go with it."""
        self.kill()
