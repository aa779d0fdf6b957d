"""The one door to an object store: fsspec's file system, its complaints as sentences of ours.

Credentials and addresses are those of the environment and of fsspec's own configuration. Nothing
that is read from here is trusted: see ``cache.py`` and ``pack.py`` for the digests.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from motorid.errors import DataError, UsageError
from motorid.limits import refuse_size
from motorid.reading import open_file
from motorid.storage.place import Url

PIECE = 16 << 20
LONGEST_COMPLAINT = 200
PACKAGES = {"s3": "s3fs", "gs": "gcsfs", "abfs": "adlfs"}


@dataclass(frozen=True)
class Kept:
    """A file of an object store, and its bytes."""

    url: Url
    size: int


@contextmanager
def said(url: Url, does: str) -> Iterator[Any]:
    """The file system of ``url``. Raises DataError for whatever its client raises.

    ``does``: what is tried, as "be read".
    """
    system = _system(url)
    try:
        yield system
    except DataError:
        raise
    except FileNotFoundError:
        raise DataError(f"{url} is not there: check bucket and name") from None
    except Exception as error:  # the client of each store raises its own
        text = " ".join(str(error).split())[:LONGEST_COMPLAINT]
        raise DataError(f"{url} cannot {does} ({type(error).__name__}: {text})") from None


def _system(url: Url) -> Any:
    try:
        fsspec: Any = import_module("fsspec")
        return fsspec.filesystem(url.scheme, use_listings_cache=False)
    except ImportError:
        needs = "'motorid[plant]'" if url.scheme == "s3" else PACKAGES.get(url.scheme, "fsspec")
        raise UsageError(f"{url.scheme}:// needs a package: pip install {needs}") from None


def read(url: Url, start: int | None = None, end: int | None = None) -> bytes:
    """All of a file, or the bytes from ``start`` to ``end``. Raises DataError."""
    if start is None:
        refuse_size(str(url), length(url))
    with said(url, "be read") as system:
        return bytes(system.cat_file(url.key, start=start, end=end))


def length(url: Url) -> int:
    """Bytes of a file. Raises DataError where it is none."""
    with said(url, "be read") as system:
        found = system.info(url.key)
        if found["type"] != "file":
            raise DataError(f"{url} is a folder: name a file in it")
        return int(found["size"])


def exists(url: Url) -> bool:
    """Whether there is such a file. Raises DataError where the store does not answer."""
    with said(url, "be looked for") as system:
        try:
            return bool(system.info(url.key)["type"] == "file")
        except FileNotFoundError:
            return False


def files(url: Url) -> list[Kept]:
    """The files under a folder, at any depth, by name. Raises DataError."""
    with said(url, "be listed") as system:
        found = system.find(url.key, detail=True)
        kept = [Kept(_again(url, name), int(info["size"])) for name, info in found.items()]
    return sorted(kept, key=lambda one: one.url)


def _again(url: Url, name: str) -> Url:
    """The URL of a name as the file system says it."""
    return Url(f"{url.scheme}://{name.removeprefix(f'{url.scheme}://').lstrip('/')}")


def sha256_of(url: Url) -> str:
    """The digest of a file as the store gives it, in pieces. Raises DataError."""
    digest, whole = hashlib.sha256(), length(url)
    for start in range(0, whole, PIECE):
        digest.update(read(url, start, min(start + PIECE, whole)))
    return digest.hexdigest()


def put(path: Path, url: Url, *, force: bool = False) -> str:
    """Copies a file into the store and reads it back; its SHA-256.

    The same file may be put twice. Raises UsageError where the store holds another one under that
    name (unless ``force``), DataError where it does not take it, or gives back something else.
    """
    with open_file(path, DataError) as file:
        data = file.read()
    sha256 = hashlib.sha256(data).hexdigest()
    if not force and exists(url):
        if sha256_of(url) == sha256:
            return sha256
        raise UsageError(f"{url} exists already, with another content: name another place")
    faster = contextlib.suppress(FileExistsError)  # another one was: that is read back
    with said(url, "be written") as system, faster:
        system.pipe_file(url.key, data, mode="overwrite" if force else "create")
    if sha256_of(url) != sha256:
        raise DataError(f"{url}: the store gives back another content than {path} has")
    return sha256


def remove(url: Url) -> None:
    """Deletes a file. Raises DataError."""
    with said(url, "be deleted") as system:
        system.rm_file(url.key)
