"""One zip that holds a board's evidence: every file with its SHA-256, in a sealed manifest."""

from __future__ import annotations

import hashlib
import re
import tempfile
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from motorid import json_seal, json_text
from motorid.capture.whole import write_whole
from motorid.errors import DataError
from motorid.limits import BUNDLE, refuse_large
from motorid.reading import size

SCHEMA = "motorid-conformance-1"
MANIFEST = "manifest.json"
DATE = (1980, 1, 1, 0, 0, 0)  # of every member: the same files make the same bytes
_NAME = re.compile(r"[\w-][\w.-]*(?:/[\w-][\w.-]*)*\Z", re.ASCII)

_BAD = (zipfile.BadZipFile, OSError, ValueError, TypeError, AttributeError, NotImplementedError,
        RuntimeError, EOFError, zlib.error)  # fmt: skip


def pack(folder: Path, target: Path, about: Mapping[str, Any], *, force: bool = False) -> Path:
    """The bundle of all files in ``folder``, whole or not at all; returns ``target``."""
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != MANIFEST)
    names = {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}
    listed = {
        name: {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
        for name, data in names.items()
    }
    manifest = json_seal.sealed({"schema": SCHEMA, **about, "files": listed})
    text = json_text.dumps(manifest, indent=2) + "\n"
    (folder / MANIFEST).write_text(text, encoding="utf-8")
    with tempfile.TemporaryFile() as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as bundle:
            for name, data in {MANIFEST: text.encode(), **names}.items():
                bundle.writestr(_member(name), data)
        file.seek(0)
        write_whole(target, file.read(), force=force)
    return target


def _member(name: str) -> zipfile.ZipInfo:
    found = zipfile.ZipInfo(name, DATE)
    found.compress_type = zipfile.ZIP_DEFLATED
    found.external_attr = 0o644 << 16
    return found


def is_bundle(path: Path) -> bool:
    """Whether a file is a zip with a manifest of ours, whatever its state."""
    try:
        with zipfile.ZipFile(path) as bundle:
            return SCHEMA.encode() in _read(bundle, MANIFEST, path)
    except (DataError, KeyError, *_BAD):
        return False


def unpack(path: Path, folder: Path) -> dict[str, Any]:
    """The manifest of a bundle whose files all are what it says; they are put into ``folder``.

    Raises DataError, naming the file, where one is missing, foreign, another or unreadable.
    """
    refuse_large(path, BUNDLE)
    try:
        with zipfile.ZipFile(path) as bundle:
            (folder / MANIFEST).write_bytes(_read(bundle, MANIFEST, path))
            manifest = json_seal.read(folder / MANIFEST, "a bundle's manifest")
            _check_names(bundle, manifest, path)
            for name, fact in manifest["files"].items():
                data = _read(bundle, name, path)
                if hashlib.sha256(data).hexdigest() != fact["sha256"]:
                    raise DataError(f"{path}: {name} in it is not what the manifest says")
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (folder / name).write_bytes(data)
            return manifest
    except KeyError as error:
        raise DataError(f"{path}: {error.args[0]}: is it a bundle of motorid's?") from None
    except _BAD as error:
        raise DataError(f"{path} is damaged, or no bundle ({str(error)[:80]})") from None


def _read(bundle: zipfile.ZipFile, name: str, path: Path) -> bytes:
    """One member, of no more bytes than a bundle may have, whatever its head says."""
    with bundle.open(name) as file:
        data = file.read(BUNDLE.file + 1)
    if len(data) > BUNDLE.file:
        raise DataError(f"{path}: {name} in it is larger than {size(BUNDLE.file)}")
    return data


def _check_names(bundle: zipfile.ZipFile, manifest: Mapping[str, Any], path: Path) -> None:
    """Every member once, none foreign, all together no larger than a bundle may be."""
    if not str(manifest.get("schema", "")).startswith("motorid-conformance-"):
        raise DataError(f"{path} is no bundle of a conformance run")
    names, listed = bundle.namelist(), {MANIFEST, *manifest["files"]}
    if BUNDLE.rows is not None and len(names) > BUNDLE.rows:
        raise DataError(f"{path} holds {len(names)} files, and a bundle {BUNDLE.rows} at most")
    wrong = sorted(set(names) ^ listed) or sorted({n for n in names if names.count(n) > 1})
    wrong += [name for name in sorted(listed) if not _NAME.match(name) or ".." in name]
    if wrong:
        raise DataError(
            f"{path}: {wrong[0]!r} is in the zip or in its manifest, and not once in both"
        )
    if sum(one.file_size for one in bundle.infolist()) > BUNDLE.file:
        raise DataError(f"{path} unpacks to more than {size(BUNDLE.file)}")
