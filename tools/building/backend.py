"""The build backend: that of setuptools, which also asks for ziglang where no C compiler is."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import zig_build
from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403  # all hooks of a backend but those below

PYPROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"


def get_requires_for_build_wheel(settings: Any = None) -> list[str]:
    """What a wheel's build needs beside build-system.requires."""
    return [*build_meta.get_requires_for_build_wheel(settings), *compiler()]


def get_requires_for_build_editable(settings: Any = None) -> list[str]:
    """The same of an editable installation."""
    return [*build_meta.get_requires_for_build_editable(settings), *compiler()]


def compiler() -> list[str]:
    """The pinned ziglang, where zig is to build; nothing where this machine's compiler does."""
    if not zig_build.asked():
        return []
    table = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))
    return [str(one) for one in table["dependency-groups"]["compiler"]]
