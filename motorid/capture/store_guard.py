"""Access to an HDF5 file that may be damaged, foreign or hostile: sizes and types before data."""

from __future__ import annotations

from typing import Any

import h5py

from motorid.errors import DataError
from motorid.limits import CAPTURE

MAX_MEMBERS = CAPTURE.columns or 0  # columns, or provenance entries
MAX_DATA = 8 * (CAPTURE.numbers or 0)  # bytes
MAX_INFLATION = 1100  # what deflate can do at best: a column that claims more is a lie
FILTERS = frozenset({1, 2, 3})  # HDF5 numbers of deflate, shuffle and checksum


class Guard:
    """Groups, datasets and attributes of an open file of ``size`` bytes; each raises DataError.

    Only hard links are followed, so that no file reaches into another.
    """

    def __init__(self, file: h5py.File, size: int) -> None:
        self.file = file
        self.budget = min(MAX_DATA, MAX_INFLATION * size)

    def members(self, group: h5py.Group) -> list[str]:
        """Names in a group."""
        if len(group) > MAX_MEMBERS:
            raise DataError(f"{group.name} has {len(group)} entries: not a motorid capture")
        return list(group)

    def object(self, group: h5py.Group, name: str) -> Any:
        """The group or dataset of that name."""
        link = group.get(name, getlink=True)
        if link is None:
            raise DataError(f"{name} is missing: the file is damaged")
        if not isinstance(link, h5py.HardLink):
            raise DataError(f"{name} points outside the file: refused")
        return group[name]

    def group(self, parent: h5py.Group, name: str) -> h5py.Group:
        """The group of that name."""
        found = self.object(parent, name)
        if not isinstance(found, h5py.Group):
            raise DataError(f"{name} is not a group: the file is damaged")
        return found

    def dataset(self, parent: h5py.Group, name: str, rank: int) -> h5py.Dataset:
        """The dataset of that name and number of dimensions, whose data may be read."""
        found = self.object(parent, name)
        if not isinstance(found, h5py.Dataset) or found.shape is None or found.ndim != rank:
            raise DataError(f"{name} is not a {rank}-dimensional dataset: the file is damaged")
        self.readable(found, name)
        return found

    def readable(self, dataset: h5py.Dataset, name: str) -> None:
        """Raises unless the file itself holds the data and is large enough for them."""
        if dataset.external or dataset.is_virtual:
            raise DataError(f"{name} keeps its data outside the file: refused")
        filters = dataset.id.get_create_plist()
        if any(filters.get_filter(i)[0] not in FILTERS for i in range(filters.get_nfilters())):
            raise DataError(f"{name} is compressed in a way that motorid does not read")
        if CAPTURE.rows is not None and dataset.ndim and len(dataset) > CAPTURE.rows:
            raise DataError(
                f"{name} claims {len(dataset):,} rows, and a capture may have {CAPTURE.rows:,}: "
                "it claims more data than the file can hold, or is too long to be read"
            )
        self.spend(dataset.size * dataset.dtype.itemsize, name)

    def spend(self, size: int, name: str) -> None:
        """Notes that ``size`` bytes will be read. Raises where that is more than can be."""
        self.budget -= size
        if self.budget < 0:
            raise DataError(f"{name} claims more data than the file can hold: it is damaged")
