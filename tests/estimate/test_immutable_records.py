"""What one room hands to the next is a record that nobody rewrites."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from dataclasses import FrozenInstanceError, fields, is_dataclass

import pytest

import motorid.estimate
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.model.extended_terms import Term

ROOMS = [info.name for info in pkgutil.iter_modules(motorid.estimate.__path__)]
WORKING = {  # filled while they are used
    "uncertainty": {"_Sums"}, "model": {"Mixer"}, "effects": {"Setup"},
    "solver": {"Point", "Normal", "Products", "Moving", "_Own"},
}  # fmt: skip


def records(room: str, within: str = "motorid.estimate") -> list[type]:
    """Each dataclass of a room that has fields."""
    whole = importlib.import_module(f"{within}.{room}")
    found = []
    for info in pkgutil.walk_packages(whole.__path__, f"{whole.__name__}."):
        for _, one in inspect.getmembers(importlib.import_module(info.name), inspect.isclass):
            if is_dataclass(one) and fields(one) and one.__module__ == info.name:
                found.append(one)
    return found


def writable(one: type) -> bool:
    """Whether a field of a new, empty instance can be set."""
    try:
        setattr(one.__new__(one), fields(one)[0].name, None)  # type: ignore[arg-type]
    except FrozenInstanceError:
        return False
    return True


@pytest.mark.parametrize("room", ROOMS)
def test_records_of_a_room_are_immutable(room: str) -> None:
    assert {one.__name__ for one in records(room) if writable(one)} == WORKING.get(room, set())


def test_every_room_has_records() -> None:
    assert set(WORKING) < set(ROOMS)
    assert len(records("results")) > 10


@pytest.mark.parametrize("one", [InfluenceQuantity, Term])
def test_a_declaration_is_the_same_as_itself_alone(one: type) -> None:
    assert vars(one).get("__eq__") is None
    assert one.__hash__ is object.__hash__
