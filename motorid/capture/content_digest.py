"""The SHA-256 of all that an HDF5 file says, kept in the file: any change of it is seen.

It covers names, types, shapes and values, not the bytes on disk, so that h5repack leaves it true.
docs/file-format.md defines it.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from typing import Any

import h5py
import numpy as np

from motorid.capture.store_guard import Guard
from motorid.errors import DataError

ATTRIBUTE = "content_sha256"  # of the root; the only thing that the digest leaves out
MAX_DEPTH = 8
MAX_OBJECTS = 512
MAX_ATTRIBUTES = 256  # of one object
MAX_VALUES = 1 << 16  # of one attribute
HDF5_ERRORS = (OSError, RuntimeError, KeyError, ValueError, TypeError, OverflowError, MemoryError)


def seal(file: h5py.File) -> None:
    """Puts the digest of what ``file`` holds now into it."""
    file.attrs[ATTRIBUTE] = content_sha256(file, np.iinfo(np.int64).max)


def carried(file: h5py.File) -> str:
    """The digest that ``file`` carries, true or not; "" where it carries none."""
    return str(file.attrs[ATTRIBUTE]) if ATTRIBUTE in file.attrs else ""


def checked(file: h5py.File, size: int) -> str:
    """As ``carried``. Raises DataError where what a file of ``size`` bytes holds is not that."""
    stored = carried(file)
    if stored and stored != content_sha256(file, size):
        raise DataError(
            "its content is not what its digest says: the file is damaged, or was edited; "
            "take another copy of it"
        )
    return stored


def content_sha256(file: h5py.File, size: int) -> str:
    """The digest of an open file of ``size`` bytes. Raises DataError where it cannot be read."""
    digest = hashlib.sha256()
    for path, item in _objects(Guard(file, size), file):
        try:
            for part in _parts(path, item):
                digest.update(len(part).to_bytes(8, "little"))
                digest.update(part)
        except HDF5_ERRORS as error:
            what = str(error).splitlines()[0][:200] if str(error) else type(error).__name__
            raise DataError(f"{path or 'the root'} is damaged ({what})") from None
    return digest.hexdigest()


def _objects(guard: Guard, root: h5py.Group) -> Iterator[tuple[str, Any]]:
    """Every group and dataset with its path, in the order of the paths."""
    found: dict[str, Any] = {"": root}
    waiting = [""]
    while waiting:
        parent = waiting.pop()
        for name in guard.members(found[parent]):
            path = f"{parent}/{name}"
            found[path] = item = guard.object(found[parent], name)
            if isinstance(item, h5py.Group):
                waiting.append(path)
            elif isinstance(item, h5py.Dataset):
                guard.readable(item, path)
            if path.count("/") > MAX_DEPTH or len(found) > MAX_OBJECTS:
                raise DataError("it holds more than a motorid capture does: is it damaged?")
    for path in sorted(found):
        yield path, found[path]


def _parts(path: str, item: Any) -> Iterator[bytes | memoryview]:
    """What an object adds to the digest: kind, path, its value, and its attributes by name."""
    if isinstance(item, h5py.Dataset):
        yield b"dataset"
        yield _text(path)
        yield from _value(item[()], item.dtype, item.shape, path)
    elif isinstance(item, h5py.Group):
        yield b"group"
        yield _text(path)
    else:
        raise DataError(f"{path} is neither group nor dataset: the file is damaged")
    if len(item.attrs) > MAX_ATTRIBUTES:
        raise DataError(f"{path} has {len(item.attrs)} attributes: the file is damaged")
    for name in sorted(item.attrs):
        if (path, name) != ("", ATTRIBUTE):
            yield b"attribute"
            yield _text(name)
            yield from _attribute(item, name, f"{path}@{name}")


def _attribute(item: Any, name: str, where: str) -> Iterator[bytes | memoryview]:
    handle = item.attrs.get_id(name)
    shape, dtype = handle.shape, handle.dtype
    if shape is None or math.prod(shape) > MAX_VALUES:
        raise DataError(f"{where} has a size that no capture has: the file is damaged")
    if dtype.kind in "iuf" and dtype.metadata is None:  # in one step, for there are a hundred
        value = np.empty(shape, dtype)
        handle.read(value)
    else:
        value = item.attrs[name]
    yield from _value(value, dtype, shape, where)


def _value(value: Any, dtype: Any, shape: Any, where: str) -> Iterator[bytes | memoryview]:
    """Type, shape and data: numbers little-endian, texts as UTF-8, tables column by column."""
    if dtype.names:
        yield b"table"
        for name in dtype.names:
            yield _text(name)
            yield from _value(value[name], dtype[name], shape, where)
    elif h5py.check_string_dtype(dtype) is not None:
        yield b"text"
        yield repr(tuple(shape)).encode()
        yield from (_text(one) for one in np.asarray(value, dtype=object).ravel())
    elif dtype.kind in "iufb" and not _refers(dtype):
        plain = dtype.newbyteorder("<")
        yield plain.str.encode()
        yield repr(tuple(shape)).encode()
        yield np.ascontiguousarray(value, dtype=plain).data.cast("B")
    else:
        raise DataError(f"{where} holds {dtype}, which no capture does: the file is damaged")


def _refers(dtype: Any) -> bool:
    return h5py.check_ref_dtype(dtype) is not None or h5py.check_vlen_dtype(dtype) is not None


def _text(text: Any) -> bytes:
    data = text if isinstance(text, bytes) else str(text).encode("utf-8", "surrogateescape")
    return bytes(data).rstrip(b"\0")
