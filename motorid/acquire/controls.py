"""What a viewer may ask of a scope: from the thread that hears it to the one that drives."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from motorid.program import Program

BUSY = "a program runs already: stop it, or wait for its end"


class Press:
    """One program that one viewer asked for. ``requested`` says that it must end.

    It ends when somebody asks so, and when its viewer has not been heard for ``silence_s``.
    """

    def __init__(
        self, program: Program, silence_s: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.program, self.silence_s = program, silence_s
        self._clock = clock
        self._heard = clock()
        self._stopped = ""

    def hear(self) -> None:
        """Its viewer is there."""
        self._heard = self._clock()

    def stop(self, why: str) -> None:
        """Ends it; the first reason stays."""
        self._stopped = self._stopped or why

    @property
    def requested(self) -> bool:
        """Whether it must end."""
        if not self._stopped and self._clock() - self._heard > self.silence_s:
            self.stop(f"the page was silent for {self.silence_s:g} s")
        return bool(self._stopped)

    @property
    def why(self) -> str:
        """Why it must end; "" while it need not."""
        return self._stopped


class Controls:
    """A desk with one place: a press waits there until it is taken, and stays until it is over."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._press: Press | None = None
        self._taken = False

    def offer(self, press: Press) -> str:
        """Puts a press on the desk; why not, or ""."""
        with self._lock:
            if self._press is not None:
                return BUSY
            self._press, self._taken = press, False
            return ""

    def stop(self, why: str) -> None:
        """Ends what lies there, begun or not."""
        with self._lock:
            if self._press is not None:
                self._press.stop(why)

    @property
    def waiting(self) -> bool:
        """Whether a press lies there that nobody has begun."""
        return self._press is not None and not self._taken

    def take(self) -> Press | None:
        """The press to begin now, if any; ``over`` frees its place."""
        with self._lock:
            if self._press is None or self._taken:
                return None
            self._taken = True
            return self._press

    def over(self) -> None:
        """What was taken has ended."""
        with self._lock:
            self._press = None
