"""Values on the command line: numbers that are finite and can be counted to, names that name."""

from __future__ import annotations

import math
from typing import Any

import click

MOST = (1 << 31) - 1


def finite(text: str) -> float:
    """The number in ``text``. Raises ValueError for none, for infinity and for NaN."""
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is not a finite number")
    return value


class Finite(click.types.FloatParamType):
    """A number; neither infinity nor NaN, which pass every comparison or none."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        return _finite(self, super().convert(value, param, ctx), param, ctx)


class Between(click.FloatRange):
    """The same within a range."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        return _finite(self, super().convert(value, param, ctx), param, ctx)


class Whole(click.IntRange):
    """A whole number within a range, and never beyond 32 bits."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        found: int = super().convert(value, param, ctx)
        if not -MOST <= found <= MOST:
            self.fail("the number is out of range.", param, ctx)
        return found


class Jobs(Whole):
    """A number of processes; -1 is one a core."""

    name = "integer"

    def __init__(self) -> None:
        super().__init__(min=-1, max=1024)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        found = super().convert(value, param, ctx)
        if found == 0:
            self.fail("0 processes do nothing: give -1 for one a core, or a number.", param, ctx)
        return found

    def _describe_range(self) -> str:
        return ""


class Named(click.Path):
    """A path with a name; the empty one would be the folder that one is in."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not str(value):
            self.fail("it is empty: name a file or a folder.", param, ctx)
        return super().convert(value, param, ctx)


class Kept(Named):
    """The same, or a URL of an object store."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        from motorid.storage.place import file, is_url

        if isinstance(value, str) and is_url(value):
            return file(value)
        return super().convert(value, param, ctx)


def _finite(
    kind: click.ParamType[float],
    value: float,
    param: click.Parameter | None,
    ctx: click.Context | None,
) -> float:
    if not math.isfinite(value):
        kind.fail(f"{value} is not a finite number.", param, ctx)
    return value


FINITE, JOBS = Finite(), Jobs()
