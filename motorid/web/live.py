"""The live page: samples as they come, and with leave the buttons that drive."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from motorid.acquire.controls import Controls, Press
from motorid.errors import UsageError
from motorid.program import Decay, Program, Step, StepKind
from motorid.web.guard import App
from motorid.web.hub import Hub
from motorid.web.pages import app_of

START = "live.html"
Check = Callable[[Program], None]  # raises what is wrong with a program


class Desk:
    """What a page may ask where driving is allowed: the rig's program, a pulse, a stop."""

    def __init__(
        self, controls: Controls, program: Program, silence_s: float, check: Check
    ) -> None:
        self.controls, self.program = controls, program
        self.silence_s, self.check = silence_s, check

    def press(self, asked: dict[str, Any]) -> Press:
        """The press that a page asked for, on the desk. Raises MotoridError where it may not be."""
        program = self.program if asked.get("what") == "program" else _pulse(asked)
        self.check(program)
        press = Press(program, self.silence_s)
        if refusal := self.controls.offer(press):
            raise UsageError(refusal)
        return press


class Hand:
    """One page at the desk. What it pressed ends with it."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.pressed: Press | None = None

    def hear(self, asked: dict[str, Any]) -> None:
        """Carries out one order; see ``pages.Talker``."""
        match asked.get("ask"):
            case "beat":
                if self.pressed is not None:
                    self.pressed.hear()
            case "stop":
                self.desk.controls.stop("the page asked for it")
            case "press":
                self.pressed = self.desk.press(asked)

    def gone(self) -> None:
        """See ``pages.Talker``."""
        if self.pressed is not None:
            self.pressed.stop("the page has gone")


def _pulse(asked: dict[str, Any]) -> Program:
    numbers = []
    for name in ("volts", "seconds"):
        value = asked.get(name)
        good = isinstance(value, int | float) and not isinstance(value, bool)
        if not good or not math.isfinite(float(value or 0)):
            raise UsageError(f"a pulse needs {name}, a number")
        numbers.append(float(value or 0))
    volts, seconds = numbers
    if not seconds > 0:
        raise UsageError("a pulse lasts longer than 0 s")
    drive = Step(StepKind.DRIVE_VOLTS, seconds, volts, Decay.SYNCHRONOUS_SLOW)
    return Program((drive, Step(StepKind.COAST, 1.0)))


def live_app(hub: Hub, desk: Desk | None = None) -> App:
    """The page of ``hub``. Without a ``desk`` it only watches."""
    return app_of(hub, START, None if desk is None else lambda caller: Hand(desk))
