"""A supply or source-measure unit that drives the motor: guarded first, and switched off at last.

Nothing here can open a bridge: the output stays as it was last told when this computer dies. So
over-voltage and over-current protection are set, switched on and read back before the output is.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from motorid.acquire.scpi.dialect import Dialect
from motorid.acquire.scpi.link import Instrument, written
from motorid.errors import LinkError, MotoridError, RigError

ABOVE = 0.01  # relative, by which a protection may read back above what was asked for
LEAST_ABOVE = {"V": 0.02, "A": 0.005}  # or by so much: one step of a coarse setting
BELOW = 0.9  # relative: below it a protection would trip where the rig allows the run
SETTING = 0.01  # relative, of a voltage that was set
ATTEMPTS = 3  # to switch an output off
WORDS = {"ON": True, "TRUE": True, "YES": True, "OFF": False, "FALSE": False, "NO": False}


class Supply:
    """One output, told by its dialect."""

    def __init__(
        self,
        instrument: Instrument,
        dialect: Dialect,
        channel: str = "1",
        reopen: Callable[[], Instrument] | None = None,
    ) -> None:
        self.instrument, self._dialect = instrument, dialect
        self._channel, self._reopen = channel, reopen
        self.limit_a = math.inf
        self.settings: dict[str, float] = {}  # of protection and limit, as they were read back

    # ---------------------------------------------------------------- before a run

    def prepare(self) -> None:
        """Selects the output, and has it off. Raises RigError or LinkError."""
        for line in self._dialect.prepare:
            self.instrument.command(self._text(line))
        self.off()

    def protect(self, volts: float, amperes: float) -> None:
        """Sets both protections and the current limit, and reads each back.

        Raises RigError where one cannot be set, does not read back, or is not on.
        """
        self._level("over_voltage", volts, "V")
        self._switched_on("over_voltage")
        self.limit_a = self._level("current_limit", amperes, "A")
        if not self._dialect.get("current_limit", "protects"):
            if self._dialect.get("over_current", "set"):
                self._level("over_current", amperes, "A")
            self._switched_on("over_current")
        if found := self.tripped():
            raise RigError(
                f"the supply's {found} protection has tripped already: find out why, and clear it"
            )

    def _level(self, section: str, wanted: float, unit: str) -> float:
        what = section.replace("_", "-")
        ask = self._needed(section, "ask")
        self.instrument.command(self._text(self._needed(section, "set"), value=written(wanted)))
        found = self.instrument.number(self._text(ask))
        high = wanted + max(ABOVE * wanted, LEAST_ABOVE[unit])
        if not BELOW * wanted <= found <= high:
            raise RigError(
                f"the supply's {what} was set to {wanted:g} {unit} and reads back {found:g} {unit}:"
                " nothing is switched on; choose another range, or correct the dialect"
            )
        self.settings[section] = found
        return found

    def _switched_on(self, section: str) -> None:
        """On by a switch that reads back; or by its level alone, where it has no switch."""
        if not self._dialect.get(section, "on") and self._dialect.get(section, "set"):
            return
        self.instrument.command(self._text(self._needed(section, "on")))
        answer = self.instrument.ask(self._text(self._needed(section, "is_on")))
        if not truth(answer):
            raise RigError(
                f"the supply's {section.replace('_', '-')} protection was switched on and reads "
                f"back {answer!r}: nothing is switched on"
            )

    def _needed(self, section: str, key: str) -> str:
        found: str = self._dialect.get(section, key)
        if not found:
            raise RigError(
                f"the dialect {self._dialect.name} has no {section}.{key}: without "
                f"{section.replace('_', '-')} protection that is set and read back nothing is "
                "switched on"
            )
        return found

    # ---------------------------------------------------------------- the run

    def set(self, volts: float) -> None:
        """Sets the level and reads it back. Raises RigError where it is another."""
        self.instrument.command(
            self._text(self._dialect.get("voltage", "set"), value=written(volts))
        )
        found = self.instrument.number(self._text(self._dialect.get("voltage", "ask")))
        if not abs(found - volts) <= max(SETTING * abs(volts), LEAST_ABOVE["V"]):
            raise RigError(
                f"the supply was set to {volts:g} V and reads back {found:g} V: is that level in "
                "its range, and its display unlocked?"
            )

    def on(self) -> None:
        """Switches the output on, and sees that it is. Raises RigError."""
        self.instrument.command(self._text(self._dialect.get("output", "on")))
        if not self.is_on():
            why = self.tripped()
            raise RigError(
                "the supply's output was switched on and reads back off"
                + (f": its {why} protection tripped" if why else "")
            )

    def off(self) -> None:
        """Switches the output off and sees that it is, over a fresh link if need be.

        Raises LinkError where that cannot be seen: then it may be on.
        """
        problem = ""
        for attempt in range(ATTEMPTS):
            try:
                if attempt and self._reopen is not None:
                    self.instrument = self._reopen()
                self.instrument.command(self._text(self._dialect.get("output", "off")))
                if not self.is_on():
                    return
                problem = "it reads back on"
            except MotoridError as error:
                problem = str(error)
        raise LinkError(
            "THE SUPPLY'S OUTPUT MAY STILL BE ON: switch it off by hand; it was told to "
            f"{ATTEMPTS} times ({problem})"
        )

    def is_on(self) -> bool:
        """Whether the output says that it is on. Raises LinkError on another answer."""
        answer = self.instrument.ask(self._text(self._dialect.get("output", "ask")))
        found = truth(answer)
        if found is None:
            raise LinkError(f"the supply says of its output {answer[:40]!r}, neither on nor off")
        return found

    def limited(self) -> bool:
        """Whether it limits the current, or has since it was asked last; False: it cannot say."""
        ask = self._dialect.get("limiting", "ask")
        if not ask:
            return False
        answer = self.instrument.ask(self._text(ask))
        if word := self._dialect.get("limiting", "word"):
            return str(word).upper() in answer.upper()
        try:
            register = int(float(answer))
        except ValueError:
            raise LinkError(f"the supply answers {ask!r} with {answer[:40]!r}") from None
        return bool(register & int(self._dialect.get("limiting", "mask") or 1))

    def tripped(self) -> str:
        """Which protection has tripped, by name; "": none, or it cannot say."""
        for section in ("over_voltage", "over_current"):
            ask = self._dialect.get(section, "tripped")
            if ask and truth(self.instrument.ask(self._text(ask))) is not False:
                return section.replace("_", "-")
        return ""

    def measure_query(self, quantity: str) -> str:
        """The query of its own reading; "" where the dialect has none."""
        return self._text(self._dialect.get("measure", quantity))

    def close(self) -> None:
        """Gives the link back."""
        self.instrument.close()

    def _text(self, template: str, value: str = "") -> str:
        return template.format_map({"value": value, "channel": self._channel})


def truth(answer: str) -> bool | None:
    """What a supply means by 1, +0, ON or NO; None where that is neither yes nor no."""
    word = answer.strip().strip('"').upper()
    try:
        return bool(float(word))
    except ValueError:
        return WORDS.get(word)
