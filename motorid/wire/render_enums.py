"""The protocol's enumerations as Python source."""

from __future__ import annotations

from collections.abc import Mapping

from motorid.wire.spec import Spec

HEAD = '''"""The protocol's enumerations. Generated from spec.toml: do not edit."""

from enum import IntEnum
'''


def class_name(enum: str) -> str:
    """``end_reason`` -> ``EndReason``."""
    return "".join(part.capitalize() for part in enum.split("_"))


def render(spec: Spec) -> str:
    """The whole of ``enums.py``."""
    return HEAD + "".join(_enum(name, values) for name, values in spec.enums.items())


def _enum(name: str, values: Mapping[str, int]) -> str:
    members = "".join(f"    {key.upper()} = {value}\n" for key, value in values.items())
    return f"\n\nclass {class_name(name)}(IntEnum):\n{members}"
