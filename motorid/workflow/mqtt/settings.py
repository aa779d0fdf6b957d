"""Which broker, under which topics, and as whom: the file that ``--mqtt`` names."""

from __future__ import annotations

import os
import re
import ssl
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from motorid.errors import UsageError
from motorid.toml_file import read_text, tables_of, unknown

PASSWORD = "MOTORID_MQTT_PASSWORD"  # noqa: S105 - a variable of the environment
PORTS = {"mqtt": 1883, "mqtts": 8883}
LOOPBACK = ("127.0.0.1", "::1", "localhost")
LEVEL = re.compile(r"[^/+#\x00-\x1f\x7f]{1,200}")  # of a topic
KEYS = (
    *("url", "topic", "user", "password_file", "ca_file", "plain"),
    *("acknowledged", "repeat_s"),
)


@dataclass(frozen=True)
class Broker:
    """``acknowledged``: a consumer says which verdicts it has; else the broker's word counts.

    ``repeat_s``: how long a verdict waits for that before it is sent again.
    """

    host: str
    port: int
    tls: bool
    topic: str
    user: str = ""
    password: str = field(default="", repr=False)
    ca_file: Path | None = None
    acknowledged: bool = False
    repeat_s: float = 30.0

    def context(self) -> ssl.SSLContext | None:
        """TLS 1.2 or newer; None where there is none. Raises UsageError for a CA that is none."""
        if not self.tls:
            return None
        try:
            context = ssl.create_default_context(cafile=self.ca_file)
        except (OSError, ValueError) as error:
            raise UsageError(f"ca_file {self.ca_file} holds no certificate ({error})") from None
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        return context


def read_broker(path: Path) -> Broker:
    """The broker of a settings file. Raises UsageError, naming file and key."""
    table = tables_of(read_text(path, "a file of MQTT settings", UsageError), str(path), UsageError)
    try:
        return _broker(table, path.parent)
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from None


def _broker(table: dict[str, Any], folder: Path) -> Broker:
    if problem := unknown(table, KEYS):
        raise UsageError(problem)
    host, port, tls = _place(_text(table, "url"))
    if not tls and host not in LOOPBACK and not _flag(table, "plain"):
        raise UsageError(
            f"url: {host} is reached over a network, where anybody could read and change what is "
            "said: write mqtts://, or plain = true in a network that you trust"
        )
    topic = _text(table, "topic", "motorid")
    if not all(LEVEL.fullmatch(level) for level in topic.split("/")) or topic.startswith("$"):
        raise UsageError("topic must be words between slashes, without + and #")
    ca_file = _text(table, "ca_file", "")
    user = _text(table, "user", "")
    return Broker(
        host, port, tls, topic, user, _password(table, folder) if user else "",
        folder / ca_file if ca_file else None, _flag(table, "acknowledged"), _seconds(table),
    )  # fmt: skip


def _place(url: str) -> tuple[str, int, bool]:
    try:
        parts = urlsplit(url)
        host, port = parts.hostname or "", parts.port or PORTS.get(parts.scheme, 0)
    except ValueError as error:
        raise UsageError(f"url: {error}") from None
    if parts.username is not None or parts.password is not None:
        raise UsageError("url holds no user and no password: write user and password_file")
    if parts.scheme not in PORTS or not host or parts.path not in ("", "/") or parts.query:
        raise UsageError("url must be mqtts://HOST[:PORT], or mqtt:// on this computer")
    return host, port, parts.scheme == "mqtts"


def _password(table: dict[str, Any], folder: Path) -> str:
    """From its file, else from the environment: never from a command line."""
    named = _text(table, "password_file", "")
    if not named:
        if not (found := os.environ.get(PASSWORD, "")):
            raise UsageError(f"user has no password: name password_file, or set {PASSWORD}")
        return found
    lines = read_text(folder / named, "a password", UsageError).splitlines()
    if not lines or not lines[0].strip():
        raise UsageError(f"password_file {named}: its first line is empty")
    return lines[0].strip()


def station_level(station: str) -> str:
    """A station's name as a level of topics. Raises UsageError where it cannot be one."""
    if not LEVEL.fullmatch(station):
        raise UsageError(
            "--mqtt names its topics after the station: give it a name of its own by --station, "
            "without / + and #"
        )
    return station


def _text(table: dict[str, Any], key: str, default: str | None = None) -> str:
    value = table.get(key, default)
    if not isinstance(value, str) or len(value) > 1000:
        raise UsageError(f"{key} is missing" if value is None else f"{key} must be a short text")
    return value


def _flag(table: dict[str, Any], key: str) -> bool:
    value = table.get(key, False)
    if not isinstance(value, bool):
        raise UsageError(f"{key} must be true or false")
    return value


def _seconds(table: dict[str, Any]) -> float:
    value = table.get("repeat_s", Broker.repeat_s)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.1 <= value <= 86_400:
        raise UsageError("repeat_s must be a number from 0.1 to 86400")
    return float(value)
