"""What a person may name where a capture is: a path, a URL of an object store, a pack's member.

captures/run.h5
s3://bucket/line-1/run.h5
s3://bucket/packs/line-1/2026-11-25.zip#SN-1_20261125T060102/capture.h5
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from motorid.errors import UsageError

SCHEMES = ("s3", "gs", "abfs", "memory")  # memory: of one process, for trials
PACK, IN = ".zip", "#"
_URL = re.compile(r"([a-zA-Z][a-zA-Z0-9+.-]+)://(.*)", re.DOTALL)


@dataclass(frozen=True, order=True)
class Url:
    """A file or a folder in an object store. Make it by ``place``."""

    text: str

    def __str__(self) -> str:
        return self.text

    def __truediv__(self, name: str) -> Url:
        return Url(f"{self.text.rstrip('/')}/{name}")

    @property
    def scheme(self) -> str:
        """The protocol, such as s3."""
        return self.text.partition("://")[0]

    @property
    def key(self) -> str:
        """Bucket and name, without the protocol."""
        return self.text.partition("://")[2]

    @property
    def name(self) -> str:
        """The last part."""
        return PurePosixPath(self.key).name

    @property
    def suffix(self) -> str:
        """Of the name."""
        return PurePosixPath(self.key).suffix

    @property
    def stem(self) -> str:
        """The name without its suffix."""
        return PurePosixPath(self.key).stem

    @property
    def parent(self) -> Url:
        """The folder that it is in."""
        return Url(self.text.rstrip("/").rpartition("/")[0])


@dataclass(frozen=True)
class Member:
    """One file of a pack."""

    pack: Path | Url
    inner: str

    def __str__(self) -> str:
        return f"{self.pack}{IN}{self.inner}"

    @property
    def name(self) -> str:
        """The last part."""
        return PurePosixPath(self.inner).name

    @property
    def stem(self) -> str:
        """The name without its suffix."""
        return PurePosixPath(self.inner).stem


File = Path | Url  # what bytes are kept in
Place = Path | Url | Member


def is_url(text: str) -> bool:
    """Whether ``text`` has the form of a URL."""
    return _URL.fullmatch(text) is not None


def file(text: str) -> File:
    """The path or the URL that ``text`` names. Raises UsageError for a URL of no object store."""
    found = _URL.fullmatch(text)
    if found is None:
        return Path(text)
    scheme, rest = found[1].lower(), found[2]
    bucket = rest.partition("/")[0]
    if scheme not in SCHEMES:
        raise UsageError(
            f"{scheme}://...: captures are in files or in an object store, as s3://BUCKET/NAME"
        )
    if "@" in bucket or ":" in bucket:
        raise UsageError(
            f"{scheme}://...: a URL holds bucket and name alone: credentials and address belong "
            "into the environment (AWS_ACCESS_KEY_ID, AWS_ENDPOINT_URL)"
        )
    if not bucket or not rest.isprintable():
        raise UsageError(f"{scheme}://{rest!a}: write {scheme}://BUCKET/NAME")
    return Url(f"{scheme}://{rest}")


def place(text: str) -> Place:
    """What ``text`` names; a file with a # in its name is that file where it is there."""
    pack, mark, inner = text.partition(PACK + IN)
    if not mark or not inner or (not is_url(text) and Path(text).exists()):
        return file(text)
    return Member(file(pack + PACK), inner)
