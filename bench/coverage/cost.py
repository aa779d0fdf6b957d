"""How many responses of a capture a fit computes, counted from outside of the estimator."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from motorid.motor.response import Response
from motorid.motor.wide import Posed, WideResponse


class Count:
    """Responses so far."""

    responses = 0


@contextmanager
def counted() -> Iterator[Count]:
    """Counts every run of a response within, of six parameters or more, side by side or alone."""
    count, own = Count(), {cls: cls.__call__ for cls in (Response, WideResponse)}
    several = WideResponse.several

    def counting(call: Callable[..., Any]) -> Callable[..., Any]:
        def run(*arguments: Any, **named: Any) -> Any:
            count.responses += 1
            return call(*arguments, **named)

        return run

    def side_by_side(response: WideResponse, runs: Sequence[Posed]) -> list[Any]:
        answers = several(response, runs)
        count.responses += sum(answer is not None for answer in answers)
        return answers

    try:
        for cls, call in own.items():
            setattr(cls, "__call__", counting(call))  # noqa: B010
        WideResponse.several = side_by_side  # type: ignore[method-assign]
        yield count
    finally:
        for cls, call in own.items():
            setattr(cls, "__call__", call)  # noqa: B010
        WideResponse.several = several  # type: ignore[method-assign]
