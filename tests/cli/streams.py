"""Standard streams in every state that a shell can hand them over in."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TextIO

import click

from motorid.acquire.interrupt import ASKING
from motorid.cli import main

STATES = ("open", "closed", "full", "gone")


class Refusing(io.RawIOBase):
    """A raw file whose every write fails with the error of that number."""

    def __init__(self, number: int) -> None:
        self.number = number

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        raise OSError(self.number, os.strerror(self.number))


def stream(state: str, path: Path) -> TextIO | None:
    """A stream in one of STATES; an open one writes to ``path``."""
    if state == "closed":
        return None
    if state == "open":
        return open(path, "w", encoding="utf-8")
    number = {"full": errno.ENOSPC, "gone": errno.EPIPE}[state]
    return io.TextIOWrapper(io.BufferedWriter(Refusing(number)), encoding="utf-8")


@contextlib.contextmanager
def standing(out: str, err: str, folder: Path) -> Iterator[None]:
    """The standard streams in the states named; afterwards all is as it was."""
    names = ("stdin", "stdout", "stderr", "__stdout__", "__stderr__")
    before = {name: getattr(sys, name) for name in names}
    handlers = {number: signal.getsignal(number) for number in ASKING}
    opened = [stream(out, folder / "out"), stream(err, folder / "err"), open(os.devnull)]  # noqa: SIM115
    sys.stdout, sys.stderr, sys.stdin = opened  # type: ignore[assignment]
    try:
        yield
    finally:
        for each in (sys.stdout, sys.stderr, sys.stdin):
            with contextlib.suppress(OSError):
                each.close()
        for name, value in before.items():
            setattr(sys, name, value)
        for number, handler in handlers.items():
            signal.signal(number, handler)


def run_main(
    args: list[str], folder: Path, out: str = "open", err: str = "open"
) -> tuple[int, str, str]:
    """Exit code, output and messages of the installed command with streams in these states."""
    argv = sys.argv
    for name in ("out", "err"):
        (folder / name).unlink(missing_ok=True)
    try:
        sys.argv = ["motorid", *args]
        with standing(out, err, folder):
            try:
                main.main()
            except SystemExit as end:
                code = end.code
    finally:
        sys.argv = argv
    said = [
        (folder / name).read_text(encoding="utf-8") if (folder / name).exists() else ""
        for name in ("out", "err")
    ]
    assert isinstance(code, int)
    return code, said[0], said[1]


def all_commands() -> list[tuple[str, ...]]:
    """The words of every command there is, found in the command line's own table."""

    def inside(words: tuple[str, ...], command: click.Command) -> Iterator[tuple[str, ...]]:
        if not isinstance(command, click.Group):
            yield words
            return
        context = click.Context(command)
        for name in command.list_commands(context):
            found = command.get_command(context, name)
            assert found is not None
            yield from inside((*words, name), found)

    return list(inside((), main.cli))


def command_of(words: tuple[str, ...]) -> click.Command:
    """The command of such words."""
    found: click.Command = main.cli
    for word in words:
        assert isinstance(found, click.Group)
        inner = found.get_command(click.Context(found), word)
        assert inner is not None
        found = inner
    return found
