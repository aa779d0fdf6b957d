"""Stages of a search that note what they are handed, in the place of a module's functions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest


def noting(
    monkeypatch: pytest.MonkeyPatch, module: Any, seen: dict[str, Any], **answers: Any
) -> None:
    """Stages that note what they are handed, and give these answers."""

    def stage(name: str) -> Callable[..., Any]:
        def noted(*asked: Any, **how: Any) -> Any:
            seen.setdefault(name, []).append((*asked, *how.items()))
            return answers[name]

        return noted

    for name in answers:
        monkeypatch.setattr(module, name, stage(name))
