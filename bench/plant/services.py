"""What all stations share, and what can fail: each can be killed and started again."""

from __future__ import annotations

import hashlib
import os
import pwd
import shutil
import signal
import subprocess
import time
from pathlib import Path
from typing import Any, Protocol

from tests.plant.mosquitto import Mosquitto
from tests.storage.stores import Store

PATIENCE_S = 120.0


class Service(Protocol):
    """A database, a broker, a store."""

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


class ObjectStore(Store):
    """moto's server, a stand-in for a real store: it refuses connections, and keeps what it holds.

    A SIGKILL would take its objects with it, which no real store does.
    """

    name = "store"
    SERVER = """
import sys
from moto.server import ThreadedMotoServer
server = ThreadedMotoServer("127.0.0.1", int(sys.argv[1]), verbose=False)
server.start()
port = server.get_host_and_port()[1]
print(port, flush=True)
for line in sys.stdin:
    if line == "away\\n":
        server.stop()
    else:
        server = ThreadedMotoServer("127.0.0.1", port, verbose=False)
        server.start()
    print(line, end="", flush=True)
"""

    def __init__(self) -> None:
        self.began = False
        super().__init__()

    def start(self) -> None:
        """It answers when this returns."""
        if self.began:
            self._order("back")
        else:
            super().start()
        self.began = True

    def fail(self) -> None:
        """It answers nobody any more."""
        self._order("away")

    def _order(self, word: str) -> None:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(f"{word}\n")
        self.process.stdin.flush()
        assert self.process.stdout.readline() == f"{word}\n"

    def digests(self, bucket: str) -> dict[str, str]:
        """SHA-256 of each object, by its key."""
        pages = self.client.get_paginator("list_objects_v2").paginate(Bucket=bucket)
        keys = [one["Key"] for page in pages for one in page.get("Contents", [])]
        return {key: hashlib.sha256(self.stored(bucket, key)).hexdigest() for key in keys}
