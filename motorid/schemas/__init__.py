"""The published JSON schemas (2020-12), one file each; docs/schemas.md lists them."""

from __future__ import annotations

from importlib import resources
from typing import Any

from motorid import json_text

ENDING = ".schema.json"


def names() -> tuple[str, ...]:
    """What ``schema`` takes."""
    found = (one.name for one in resources.files(__name__).iterdir())
    return tuple(sorted(one.removesuffix(ENDING) for one in found if one.endswith(ENDING)))


def schema(name: str) -> dict[str, Any]:
    """One of ``names``."""
    text = resources.files(__name__).joinpath(name + ENDING).read_text("utf-8")
    return dict(json_text.loads(text))
