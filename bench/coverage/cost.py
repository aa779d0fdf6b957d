"""How many responses of a capture a fit computes, counted from outside of the estimator."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from motorid.motor.response import Response
from motorid.motor.wide import WideResponse


class Count:
    """Responses so far."""

    responses = 0


@contextmanager
def counted() -> Iterator[Count]:
    """Counts every run of a response within, of six parameters or more."""
    count, own = Count(), {cls: cls.__call__ for cls in (Response, WideResponse)}

    def counting(call: Callable[..., Any]) -> Callable[..., Any]:
        def run(*arguments: Any, **named: Any) -> Any:
            count.responses += 1
            return call(*arguments, **named)

        return run

    try:
        for cls, call in own.items():
            setattr(cls, "__call__", counting(call))  # noqa: B010
        yield count
    finally:
        for cls, call in own.items():
            setattr(cls, "__call__", call)  # noqa: B010
