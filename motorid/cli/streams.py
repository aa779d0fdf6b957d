"""Standard streams that cannot fail: what becomes of a command never depends on its printing.

A log disk may be full, a reader may have gone, a stream may be closed. ``sturdy`` puts an outlet
under each stream that notes a failed write and never raises one, so that neither a command, nor
its report of an error, nor the interpreter's last flush can turn one outcome into another.
``lost`` says afterwards whether the answer got through.

``shown`` lies above: all text passes it, and control characters of others come out as escapes.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
import selectors
import shutil
import sys
import textwrap
from collections.abc import Iterator
from typing import Any, TextIO

import click

from motorid.errors import DataError
from motorid.visible import visible

CLOSED = OSError(errno.EBADF, "it is closed")
NARROWEST = 20  # columns that a sentence is folded to
GONE = {errno.EPIPE, errno.ESHUTDOWN, errno.ECONNRESET}  # the reader left, and may


class Outlet(io.RawIOBase):
    """The raw end of a stream. ``problem`` is why bytes were lost; ``raw`` None: it is closed."""

    def __init__(self, raw: io.RawIOBase | None) -> None:
        self.raw = raw
        self.problem: OSError | None = None if raw is not None else CLOSED
        self.touched = False  # something was to be written

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        if self.raw is None:
            raise io.UnsupportedOperation("fileno")
        return self.raw.fileno()

    def isatty(self) -> bool:
        return self.raw is not None and self.raw.isatty()

    def close(self) -> None:
        super().close()
        if self.raw is not None:
            self.raw.close()

    def write(self, data: Any) -> int:
        size = memoryview(data).nbytes
        self.touched = self.touched or size > 0
        try:
            return self._written(data)
        except OSError as error:
            self.problem = self.problem or error
            return size  # nobody above can do anything about it

    def _written(self, data: Any) -> int:
        """How many bytes went out, at least one; waits for a reader that is behind."""
        while self.raw is not None:
            count = self.raw.write(data)
            if count is not None:
                return count
            with selectors.DefaultSelector() as waiting:  # somebody made the pipe non-blocking
                waiting.register(self.raw, selectors.EVENT_WRITE)
                waiting.select()
        return memoryview(data).nbytes


class Shown(io.TextIOBase):
    """Text on its way to ``stream``, with control characters as escapes; ``paint`` leaves them.

    It has no ``buffer``, so that nobody writes around it.
    """

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return self.stream.encoding or "utf-8"

    @property
    def errors(self) -> str:  # type: ignore[override]
        return self.stream.errors or "strict"

    def writable(self) -> bool:
        return True

    def isatty(self) -> bool:
        return self.stream.isatty()

    def fileno(self) -> int:
        return self.stream.fileno()

    def flush(self) -> None:
        self.stream.flush()

    def write(self, text: str) -> int:
        self.stream.write(visible(text))
        return len(text)

    def paint(self, text: str) -> None:
        """Writes what motorid itself composed to steer a terminal."""
        self.stream.write(text)


def paint(stream: TextIO, text: str) -> None:
    """Writes ``text`` as it is, colours and cursor moves with it, and flushes."""
    getattr(stream, "paint", stream.write)(text)
    stream.flush()


def plain(stream: TextIO) -> bool:
    """Whether the encoding of ``stream`` has no braille, which small plots are made of."""
    try:
        "\u28ff".encode(stream.encoding or "utf-8")
    except (UnicodeEncodeError, LookupError):
        return True
    return False


def folded(sentence: str) -> str:
    """``sentence`` for standard error: on a terminal in lines that end between words.

    A file or a program gets it in one line.
    """
    if sys.stderr is None or not sys.stderr.isatty():
        return sentence
    return _fold(sentence, max(shutil.get_terminal_size().columns, NARROWEST))


def paged(text: str) -> str:
    """A page for standard output: on a terminal, lines too long for it end between words."""
    if sys.stdout is None or not sys.stdout.isatty():
        return text
    columns = max(shutil.get_terminal_size().columns, NARROWEST)
    return "\n".join(_fold(line, columns) for line in text.split("\n"))


def _fold(line: str, columns: int) -> str:
    if len(line) <= columns:
        return line
    indent = " " * (len(line) - len(line.lstrip()))
    if not line.strip(" ─-"):
        return line[:columns]  # a rule under a heading
    parts = textwrap.wrap(
        line.strip(),
        columns - len(indent) - 2,
        break_long_words=False,
        break_on_hyphens=False,
        replace_whitespace=False,
    )
    return f"\n{indent}  ".join([indent + parts[0], *parts[1:]])


@contextlib.contextmanager
def shown() -> Iterator[None]:
    """While it lasts, text on standard output and standard error passes ``Shown``."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (s if s is None else Shown(s) for s in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def sturdy() -> None:
    """Puts an outlet under standard output and standard error, for good; opens closed streams.

    A file that is opened while descriptor 1 is closed would get that number, and whatever a
    library or a child prints would go into it: nothing may stay closed.
    """
    _occupy_descriptors()
    if sys.stdin is None:
        sys.stdin = open(os.devnull, encoding="utf-8")  # noqa: SIM115 - lives until exit
    elif isinstance(sys.stdin, io.TextIOWrapper):
        sys.stdin.reconfigure(errors="surrogateescape")  # no text is refused where it is used
    sys.stdout = sys.__stdout__ = _on_outlet(sys.stdout)  # type: ignore[misc, assignment]
    sys.stderr = sys.__stderr__ = _on_outlet(sys.stderr)  # type: ignore[misc, assignment]


def _occupy_descriptors() -> None:
    while True:
        number = os.open(os.devnull, os.O_RDWR)
        if number > 2:
            os.close(number)
            return
        os.set_inheritable(number, True)


def _on_outlet(stream: TextIO | None) -> TextIO:
    """``stream`` rebuilt on an outlet; one that is no plain text file is left as it is."""
    if stream is None:
        return _text(Outlet(None), "utf-8", line_buffering=False)
    if not isinstance(stream, io.TextIOWrapper):
        return stream
    buffer: Any = stream.buffer
    raw = buffer if isinstance(buffer, io.RawIOBase) else getattr(buffer, "raw", None)
    if raw is None:
        return stream
    encoding, line_buffering = stream.encoding, stream.line_buffering or raw is buffer
    with contextlib.suppress(OSError):  # nothing was printed yet
        stream.flush()
    stream.detach()
    if raw is not buffer:  # which it is where Python was told not to buffer
        buffer.detach()
    return _text(Outlet(raw), encoding, line_buffering=line_buffering)


def _text(outlet: Outlet, encoding: str, *, line_buffering: bool) -> TextIO:
    """A terminal without Ω still gets its table, with a question mark in it."""
    return io.TextIOWrapper(
        io.BufferedWriter(outlet),
        encoding=encoding,
        errors="replace",
        line_buffering=line_buffering,
    )


def lost(stream: TextIO | None) -> str:
    """Why what was written to ``stream`` is not all there; nothing where it is.

    A reader that goes away has read what it wanted: nothing is lost on it.
    """
    outlet = _outlet_of(stream)
    if outlet is None or not outlet.touched or outlet.problem is None:
        return ""
    return "" if outlet.problem.errno in GONE else outlet.problem.strerror or str(outlet.problem)


def unheard(stream: TextIO | None) -> bool:
    """Whether nobody can have read what was written to ``stream`` so far: lost, or gone."""
    outlet = _outlet_of(stream)
    return outlet is not None and outlet.problem is not None


def _outlet_of(stream: TextIO | None) -> Outlet | None:
    text = stream.stream if isinstance(stream, Shown) else stream
    if isinstance(text, io.TextIOWrapper):
        text.flush()
        raw = getattr(text.buffer, "raw", None)
        return raw if isinstance(raw, Outlet) else None
    return None


def prompt(text: str, *, err: bool = False, **how: Any) -> Any:
    """As ``click.prompt``. Raises DataError where the question would be seen by nobody."""
    _refuse_unheard(err)
    return click.prompt(text, err=err, **how)


def confirm(text: str, **how: Any) -> bool:
    """As ``click.confirm``. Raises DataError where the question would be seen by nobody."""
    _refuse_unheard(err=False)
    return bool(click.confirm(text, **how))


def _refuse_unheard(err: bool) -> None:
    """A question answered unseen could set a motor going."""
    if unheard(sys.stderr if err else sys.stdout):
        name = "error" if err else "output"
        raise DataError(f"standard {name} cannot be written: the questions would be seen by nobody")
