"""The words of words.toml: which speak of a quantity, of a unit, of a set point, or of nothing."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

_TABLES = tomllib.loads(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))


def _by_word(table: str) -> Mapping[str, str]:
    """Word -> the name it stands under."""
    rows = _TABLES[table].items()
    return MappingProxyType({word: name for name, words in rows for word in words.split()})


def _set(name: str) -> frozenset[str]:
    return frozenset(_TABLES["beside"][name].split())


INDEX = "index"  # a number of the row, and no quantity
OTHER = "other"  # what a fit has no use for
LONG = 4  # letters of a word that may be part of a longer one
QUANTITY_OF = _by_word("quantity")  # of units.QUANTITIES, or INDEX
UNIT_OF, USUAL_UNIT = _by_word("unit"), _by_word("usual")
SET_POINT, OTHERS, OF_MOTOR = _set("set_point"), _set("others"), _set("of_motor")
MEASURED, FILTERED, RAW = _set("measured"), _set("filtered"), _set("raw")
