"""Run as a program: a MAT file -> its arrays. See capture/child.py."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from motorid.capture.child import serve
from motorid.errors import DataError
from motorid.limits import MAT

_MAX_DEPTH = 12
_HDF5 = b"\x89HDF\r\n\x1a\n"


def main(source: str, target: str) -> None:
    """Reads ``source`` and writes ``target``. Raises what the libraries raise."""
    with open(source, "rb") as file:
        head = file.read(1024)
    arrays: dict[str, Any] = {}
    if _HDF5 in (head[:8], head[512:520]):
        _read_hdf5(source, arrays)
    else:
        _read_v5(source, arrays)
    # np.savez takes names as keywords, which a foreign name could break: number them instead.
    named = {f"a{index}": array for index, array in enumerate(arrays.values())}
    np.savez(target, names=np.array(list(arrays), dtype=str), **named)


def _keep(name: str, value: Any, arrays: dict[str, Any]) -> None:
    """A vector or scalar of real numbers is a column; a matrix gives each of its columns."""
    array = np.asarray(value)
    if array.dtype.kind not in "iufb" or not array.size or array.ndim > 2:
        return
    refuse_shape(name, array.shape)
    array = array.astype(np.float64, copy=False)
    if array.ndim < 2 or 1 in array.shape:
        arrays[name] = array.ravel()
    elif array.shape[1] <= 64:
        for column in range(array.shape[1]):
            arrays[f"{name}[{column + 1}]"] = array[:, column]
    if MAT.columns is not None and len(arrays) > MAT.columns:
        raise DataError(f"it holds more than {MAT.columns:,} arrays, the most that it may")


def refuse_shape(name: str, shape: Sequence[int]) -> None:
    """Raises DataError for an array that is larger than the limits allow."""
    rows, numbers = max(shape, default=1), math.prod(shape)
    if (MAT.rows and rows > MAT.rows) or (MAT.numbers and numbers > MAT.numbers):
        raise DataError(
            f"{name} has {rows:,} rows and {numbers:,} numbers; a MAT file may have "
            f"{MAT.rows:,} and {MAT.numbers:,}: save a part of it"
        )


def _read_v5(source: str, arrays: dict[str, Any]) -> None:
    from scipy.io import loadmat, whosmat

    names = [(name, shape) for name, shape, _ in whosmat(source) if not name.startswith("__")]
    for name, shape in names:
        refuse_shape(name, shape)
    content = loadmat(
        source, squeeze_me=False, struct_as_record=True, verify_compressed_data_integrity=True
    )
    for name, value in content.items():
        if not name.startswith("__"):
            _walk_v5(name, value, arrays, 0)


def _walk_v5(name: str, value: Any, arrays: dict[str, Any], depth: int) -> None:
    if depth > _MAX_DEPTH or not isinstance(value, np.ndarray):
        return
    if value.dtype.names:  # a struct, or an array of them
        for index, item in enumerate(value.ravel()):
            path = name if value.size == 1 else f"{name}[{index + 1}]"
            for field in value.dtype.names:
                _walk_v5(f"{path}.{field}", item[field], arrays, depth + 1)
    elif value.dtype.kind == "O":  # a cell array
        for index, item in enumerate(value.ravel()):
            path = name if value.size == 1 else f"{name}[{index + 1}]"
            _walk_v5(path, item, arrays, depth + 1)
    else:
        _keep(name, value, arrays)


def _read_hdf5(source: str, arrays: dict[str, Any]) -> None:
    import h5py

    with h5py.File(source, "r") as file:
        for name in file:
            if name != "#refs#":
                _walk_hdf5(name, file, file.get(name, getlink=True), arrays, 0)


def _walk_hdf5(name: str, parent: Any, link: Any, arrays: dict[str, Any], depth: int) -> None:
    import h5py

    if depth > _MAX_DEPTH or not isinstance(link, h5py.HardLink):
        return  # links into other files are not followed
    node = parent[name.rpartition(".")[2]]
    _walk_node(name, node, arrays, depth)


def _walk_node(name: str, node: Any, arrays: dict[str, Any], depth: int) -> None:
    import h5py

    if isinstance(node, h5py.Group):
        for key in node:
            _walk_hdf5(f"{name}.{key}", node, node.get(key, getlink=True), arrays, depth + 1)
    elif h5py.check_ref_dtype(node.dtype) is h5py.Reference:
        _walk_references(name, node, arrays, depth)
    elif node.external or node.is_virtual or node.shape is None:
        return
    elif "MATLAB_empty" not in node.attrs and node.attrs.get("MATLAB_class") != b"char":
        refuse_shape(name, node.shape)
        _keep(name, np.asarray(node).T, arrays)  # MATLAB stores by columns


def _walk_references(name: str, node: Any, arrays: dict[str, Any], depth: int) -> None:
    """The elements of a cell or struct array: ``Y.Data`` of the third element is ``Y[3].Data``."""
    refuse_shape(name, node.shape)
    references = np.asarray(node).T.ravel(order="F")
    parent, _, field = name.rpartition(".")
    for index, reference in enumerate(references):
        if reference and depth < _MAX_DEPTH:
            path = f"{parent}[{index + 1}].{field}" if parent else f"{field}[{index + 1}]"
            _walk_node(path, node.file[reference], arrays, depth + 1)


if __name__ == "__main__":
    serve(main, ["h5py", "scipy.io"])
