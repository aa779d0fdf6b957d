"""Folders of the user on this computer, where each system has them."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from motorid.errors import DataError


def cache(name: str) -> Path:
    """What can be had again: deleting it loses nothing."""
    return _of_system("XDG_CACHE_HOME", ".cache", "Library/Caches") / "motorid" / name


def state(name: str) -> Path:
    """What is not anywhere else yet."""
    return (
        _of_system("XDG_STATE_HOME", ".local/state", "Library/Application Support")
        / "motorid"
        / name
    )


def _of_system(variable: str, usual: str, of_apple: str) -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    if sys.platform == "darwin":
        return Path.home() / of_apple
    return Path(os.environ.get(variable) or Path.home() / usual)


def made(path: Path, variable: str) -> Path:
    """``path``, made for this user alone if need be. Raises DataError, naming ``variable``."""
    try:
        path.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as error:
        raise DataError(
            f"{path} cannot be made ({error.strerror or error}): name another folder by {variable}"
        ) from None
    return path
