"""Run as a program: a MAT file -> its arrays, and what in it is none. See capture/child.py."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from motorid.capture.child import serve
from motorid.errors import DataError
from motorid.limits import MAT, beyond

_MAX_DEPTH = 12
_NARROW = 64  # columns, or rows, of a matrix that are columns of a table each
_OWN = "#"  # begins what MATLAB keeps beside the variables of a file
STREAM, BYTES, SPARSE = "Simulink signal stream", "block of raw bytes", "sparse matrix"
_PLAIN = frozenset(
    {"double", "single", "logical", "char", "struct", "cell", "canonical empty"}
    | {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
)  # MATLAB's classes whose readings are what is stored
_HDF5 = b"\x89HDF\r\n\x1a\n"


def main(source: str, target: str) -> None:
    """Reads ``source`` and writes ``target``. Raises what the libraries raise."""
    with open(source, "rb") as file:
        head = file.read(1024)
    found = Found()
    if _HDF5 in (head[:8], head[512:520]):
        _read_hdf5(source, found)
    else:
        _read_v5(source, found)
    # np.savez takes names as keywords, which a foreign name could break: number them instead.
    named = {f"a{index}": array for index, array in enumerate(found.arrays.values())}
    objects = np.array([*found.objects.items()], dtype=str).reshape(-1, 2)
    np.savez(target, names=np.array(list(found.arrays), dtype=str), objects=objects, **named)


@dataclass
class Found:
    """``arrays`` by path; ``objects``: path -> class, of what only MATLAB reads."""

    arrays: dict[str, Any] = field(default_factory=dict)
    objects: dict[str, str] = field(default_factory=dict)


def _keep(name: str, value: Any, found: Found) -> None:
    """A vector or scalar of real numbers is a column; a matrix gives its columns and its rows."""
    array = np.asarray(value)
    if array.dtype.kind not in "iufb" or not array.size:
        return
    refuse_shape(name, array.shape)
    if array.ndim > 2:  # Simulink's samples of a signal: 1 x 1 x n
        array = array.squeeze()
    if array.ndim > 2:
        return
    array = array.astype(np.float64, copy=False)
    if array.ndim < 2 or 1 in array.shape:
        found.arrays[name] = array.ravel()
    else:
        rows, columns = array.shape
        for column in range(columns if columns <= _NARROW else 0):
            found.arrays[f"{name}[{column + 1}]"] = array[:, column]
        for row in range(rows if rows <= _NARROW else 0):
            found.arrays[f"{name}[{row + 1},:]"] = array[row]
    if beyond(len(found.arrays), MAT.columns):
        raise DataError(f"it holds more than {MAT.columns:,} arrays, the most that it may")


def refuse_shape(name: str, shape: Sequence[int]) -> None:
    """Raises DataError for an array that is larger than the limits allow."""
    rows, numbers = max(shape, default=1), math.prod(shape)
    if beyond(rows, MAT.rows) or beyond(numbers, MAT.numbers):
        raise DataError(
            f"{name} has {rows:,} rows and {numbers:,} numbers; a MAT file may have "
            f"{MAT.rows:,} and {MAT.numbers:,}: save a part of it"
        )


def _read_v5(source: str, found: Found) -> None:
    from scipy.io import loadmat, whosmat

    try:
        listed = whosmat(source)
    except TypeError:  # SciPy cannot list a file with objects; the limit on memory holds for it
        listed = []
    for name, shape, _ in listed:
        if not name.startswith("__") and shape is not None:
            refuse_shape(name, shape)
    content = loadmat(
        source, squeeze_me=False, struct_as_record=True, verify_compressed_data_integrity=True
    )
    for name, value in content.items():
        if not name.startswith("__"):
            _walk_v5(name, value, found, 0)


def _walk_v5(name: str, value: Any, found: Found, depth: int) -> None:
    if hasattr(value, "todense"):
        found.objects[name] = SPARSE
    if depth > _MAX_DEPTH or not isinstance(value, np.ndarray):
        return
    if type(value).__name__ in ("MatlabOpaque", "MatlabObject", "MatlabFunction"):
        path, what = _object_v5(name, value)
        found.objects[path] = what
    elif value.dtype.names:  # a struct, or an array of them
        for index, item in enumerate(value.ravel()):
            path = name if value.size == 1 else f"{name}[{index + 1}]"
            for key in value.dtype.names:
                _walk_v5(f"{path}.{key}", item[key], found, depth + 1)
    elif value.dtype.kind == "O":  # a cell array
        for index, item in enumerate(value.ravel()):
            path = name if value.size == 1 else f"{name}[{index + 1}]"
            _walk_v5(path, item, found, depth + 1)
    else:
        _keep(name, value, found)


def _object_v5(name: str, value: Any) -> tuple[str, str]:
    """Path and class of an object. SciPy has called its parts by other names before 1.17."""
    if type(value).__name__ == "MatlabFunction":
        return name, "function handle"
    if type(value).__name__ == "MatlabObject":
        return name, str(value.classname)
    item = value.ravel()[0] if value.ndim else value[()]
    keys = value.dtype.names or ()
    what = item["_Class"] if "_Class" in keys else item["s2"] if "s2" in keys else "opaque"
    own = item["s0"] if "s0" in keys else name
    return _text(own) or name, _text(what)


def _text(what: Any) -> str:
    return what.decode("utf-8", "replace") if isinstance(what, bytes) else str(what)


def _read_hdf5(source: str, found: Found) -> None:
    import h5py

    with h5py.File(source, "r") as file:
        for name in file:
            if not name.startswith(_OWN):
                _walk_hdf5(name, file, file.get(name, getlink=True), found, 0)
            elif "stream" in name:
                found.objects[name] = STREAM


def _walk_hdf5(name: str, parent: Any, link: Any, found: Found, depth: int) -> None:
    import h5py

    if depth > _MAX_DEPTH or not isinstance(link, h5py.HardLink):
        return  # links into other files are not followed
    node = parent[name.rpartition(".")[2]]
    _walk_node(name, node, found, depth)


def _walk_node(name: str, node: Any, found: Found, depth: int) -> None:
    import h5py

    what = _text(node.attrs.get("MATLAB_class", ""))
    if "MATLAB_object_decode" in node.attrs or (what and what not in _PLAIN):
        found.objects[name] = what or "opaque"
    elif "MATLAB_sparse" in node.attrs:
        found.objects[name] = SPARSE
    elif isinstance(node, h5py.Group):
        for key in node:
            _walk_hdf5(f"{name}.{key}", node, node.get(key, getlink=True), found, depth + 1)
    elif h5py.check_ref_dtype(node.dtype) is h5py.Reference:
        _walk_references(name, node, found, depth)
    elif node.external or node.is_virtual or node.shape is None:
        return
    elif "MATLAB_empty" not in node.attrs and what != "char":
        refuse_shape(name, node.shape)
        if not what and node.dtype.kind in "iu" and node.dtype.itemsize == 1:
            found.objects[name] = BYTES  # MATLAB's own numbers of 8 bits say what they are
        else:
            _keep(name, np.asarray(node).T, found)  # MATLAB stores by columns


def _walk_references(name: str, node: Any, found: Found, depth: int) -> None:
    """The elements of a cell or struct array: ``Y.Data`` of the third element is ``Y[3].Data``."""
    refuse_shape(name, node.shape)
    references = np.asarray(node).T.ravel(order="F")
    parent, _, key = name.rpartition(".")
    for index, reference in enumerate(references):
        if reference and depth < _MAX_DEPTH:
            path = f"{parent}[{index + 1}].{key}" if parent else f"{key}[{index + 1}]"
            _walk_node(path, node.file[reference], found, depth + 1)


if __name__ == "__main__":
    serve(main, ["h5py", "scipy.io"])
