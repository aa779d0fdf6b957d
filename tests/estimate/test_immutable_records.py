"""What one room hands to the next is a record that nobody rewrites."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from dataclasses import FrozenInstanceError, fields, is_dataclass

import pytest

import motorid.estimate

WORKING = {"_Sums", "Mixer", "Setup", "Point", "Normal", "Products"}  # filled while they are used


def records() -> dict[str, type]:
    """Each dataclass of the estimator, by module and name."""
    found = {}
    for info in pkgutil.walk_packages(motorid.estimate.__path__, "motorid.estimate."):
        for name, one in inspect.getmembers(importlib.import_module(info.name), inspect.isclass):
            if is_dataclass(one) and fields(one) and one.__module__ == info.name:
                found[f"{info.name}.{name}"] = one
    return found


def writable(one: type) -> bool:
    """Whether a field of a new, empty instance can be set."""
    try:
        setattr(one.__new__(one), fields(one)[0].name, None)  # type: ignore[arg-type]
    except FrozenInstanceError:
        return False
    return True


def test_records_of_the_estimator_are_immutable() -> None:
    all_of = records()
    assert len(all_of) > 100
    found = {name.rpartition(".")[2] for name, one in all_of.items() if writable(one)}
    assert found == WORKING


@pytest.mark.parametrize("name", ["InfluenceQuantity", "Term"])
def test_a_declaration_is_the_same_as_itself_alone(name: str) -> None:
    (one,) = (c for key, c in records().items() if key.endswith(f".{name}"))
    assert one.__eq__ is object.__eq__
    assert one.__hash__ is object.__hash__
