"""An object store on this computer: moto's server, a stand-in for a real one."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import boto3

PATIENCE_S = 120.0
SERVER = """
import sys
from moto.server import ThreadedMotoServer
server = ThreadedMotoServer("127.0.0.1", int(sys.argv[1]), verbose=False)
server.start()
print(server.get_host_and_port()[1], flush=True)
sys.stdin.read()
"""
ENVIRONMENT = {
    "AWS_ACCESS_KEY_ID": "testing",
    "AWS_SECRET_ACCESS_KEY": "a-secret-of-the-test",
    "AWS_DEFAULT_REGION": "us-east-1",
    "AWS_EC2_METADATA_DISABLED": "true",
}


class Store:
    """A server in a process of its own, which can be killed. It forgets what it held."""

    SERVER = SERVER

    def __init__(self) -> None:
        self.port = 0
        self.start()

    def start(self) -> None:
        """Starts it, the second time on the port of the first."""
        self.process = subprocess.Popen(
            [sys.executable, "-c", self.SERVER, str(self.port)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env={**os.environ, **ENVIRONMENT},
        )
        assert self.process.stdout is not None
        self.port = int(self.process.stdout.readline())

    @property
    def address(self) -> str:
        """Of its HTTP."""
        return f"http://127.0.0.1:{self.port}"

    def kill(self) -> None:
        """As a power failure does."""
        self.process.kill()
        self.process.communicate()

    @property
    def client(self) -> Any:
        """Another client than motorid's."""
        return boto3.client(
            "s3",
            endpoint_url=self.address,
            aws_access_key_id=ENVIRONMENT["AWS_ACCESS_KEY_ID"],
            aws_secret_access_key=ENVIRONMENT["AWS_SECRET_ACCESS_KEY"],
            region_name=ENVIRONMENT["AWS_DEFAULT_REGION"],
        )

    def bucket(self, name: str) -> str:
        """Makes a bucket; its URL."""
        self.client.create_bucket(Bucket=name)
        return f"s3://{name}"

    def stored(self, bucket: str, key: str) -> bytes:
        """An object's bytes."""
        return bytes(self.client.get_object(Bucket=bucket, Key=key)["Body"].read())

    def keys(self, bucket: str) -> set[str]:
        """The names of a bucket's objects."""
        found = self.client.list_objects_v2(Bucket=bucket).get("Contents", [])
        return {one["Key"] for one in found}

    def put(self, bucket: str, key: str, data: bytes) -> None:
        """Puts an object there, behind motorid's back."""
        self.client.put_object(Bucket=bucket, Key=key, Body=data)


def until(happened: object, what: str) -> None:
    """Waits for an event. Fails after a time that no machine takes."""
    end = time.monotonic() + PATIENCE_S
    while not happened():  # type: ignore[operator]
        assert time.monotonic() < end, what
        time.sleep(0.02)


def folder_of(path: Path) -> set[str]:
    """Names of the files under a folder, relative to it."""
    return {one.relative_to(path).as_posix() for one in path.rglob("*") if one.is_file()}
