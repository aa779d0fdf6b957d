"""Verdicts, limits and findings are records that nobody rewrites."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from dataclasses import FrozenInstanceError, fields, is_dataclass

import pytest

import motorid.quality

MODULES = [
    info.name
    for info in pkgutil.walk_packages(motorid.quality.__path__, "motorid.quality.")
    if ".migrations" not in info.name
]


def records(module: str) -> list[type]:
    """Each dataclass of a module that has fields."""
    found = inspect.getmembers(importlib.import_module(module), inspect.isclass)
    own = [one for _, one in found if is_dataclass(one) and one.__module__ == module]
    return [one for one in own if fields(one)]


@pytest.mark.parametrize("module", MODULES)
def test_records_are_immutable(module: str) -> None:
    for one in records(module):
        with pytest.raises(FrozenInstanceError):
            setattr(one.__new__(one), fields(one)[0].name, None)  # type: ignore[arg-type]
