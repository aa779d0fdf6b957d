"""One independent computation, and the digest that names its result."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from motorid import json_text

Result = dict[str, Any]  # plain data for JSON


@dataclass(frozen=True)
class Task:
    """``work(*arguments)`` gives a Result; ``definition``, plain data, is all it depends on.

    ``failed`` gives its Result where no worker of a cluster survives it.
    """

    work: Callable[..., Result]
    arguments: tuple[Any, ...]
    definition: Mapping[str, Any]
    failed: Callable[[str], Result] | None = None

    @property
    def digest(self) -> str:
        """Name of the result's file."""
        text = json_text.canonical(self.definition)
        return hashlib.sha256(text.encode()).hexdigest()[:24]
