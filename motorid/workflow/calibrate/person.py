"""Who stands at the bench while it is calibrated: questions, and answers from a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from motorid.calibration.disc import Disc
from motorid.calibration.gain import RECTANGULAR, Meter, meter
from motorid.errors import UsageError
from motorid.toml_file import read_text, tables_of

if TYPE_CHECKING:
    from motorid.acquire.port import Port
    from motorid.rig import Rig

Setup = (
    str  # free: the motor as it runs; load: a resistor, or the shaft clamped; disc: on the shaft
)


@dataclass(frozen=True)
class Resistor:
    """A known resistor that stands in place of the motor. Uncertainty standard."""

    name: str
    serial: str
    ohm: float
    uncertainty_ohm: float


Reference = Meter | Resistor


class Person(Protocol):
    """What a calibration needs of whoever is at the bench."""

    def say(self, text: str) -> None:
        """Shows a line."""

    def ready(self, step: str, what: str) -> bool:
        """Asks to do ``what`` before ``step``; False: skip the step."""

    def proceed(self, what: str) -> None:
        """Says what happens next, and waits for leave."""

    def again(self, step: str, problem: str) -> bool:
        """Whether to repeat a step that failed, or that came out doubtful."""

    def reference(self, step: str) -> Reference:
        """What the readings are held against."""

    def reading(self, step: str, number: int, what: str) -> float:
        """What the meter shows at level ``number`` (from 0), in A or V."""

    def levels(self, step: str) -> int:
        """How many settings of the supply there will be."""

    def turn(self, turns: float) -> None:
        """Returns once the shaft was turned by hand; back where negative."""

    def disc(self, rig: Rig) -> Disc:
        """The disc's figures."""

    def arrange(self, rig: Rig, setup: Setup) -> Rig:
        """The rig with its set-up as asked for, once it is so."""

    def meet(self, port: Port) -> None:
        """Hears of the port that a step opened."""


@dataclass
class Filed:
    """Answers from a TOML file: a step without a table of its own is skipped.

    ``wait`` lets seconds pass while somebody turns the shaft.
    """

    answers: Mapping[str, Any]
    where: str
    say: Callable[[str], None]
    wait: Callable[[float], None]

    def ready(self, step: str, what: str) -> bool:
        """Whether the file has a table for the step."""
        return step in self.answers

    def proceed(self, what: str) -> None:
        """Says it and goes on."""
        self.say(what)

    def again(self, step: str, problem: str) -> bool:
        """Never: a script must not go round in circles."""
        return False

    def reference(self, step: str) -> Reference:
        """The table's meter, or its resistor."""
        return reference_of(self._table(step), f"{self.where}: [{step}]")

    def reading(self, step: str, number: int, what: str) -> float:
        """The table's readings in turn."""
        readings = self._table(step).get("readings", [])
        if not isinstance(readings, list) or number >= len(readings):
            raise UsageError(
                f"{self.where}: [{step}] needs readings = [...], one for each level: {what}"
            )
        return _number(readings[number], f"{self.where}: {step}.readings[{number}]")

    def levels(self, step: str) -> int:
        """As many as there are readings."""
        readings = self._table(step).get("readings", [])
        return len(readings) if isinstance(readings, list) else 0

    def turn(self, turns: float) -> None:
        """Gives somebody the time to do it."""
        seconds = _number(self._table("encoder").get("wait_s", 20.0), f"{self.where}: wait_s")
        way = "forwards" if turns > 0 else "back"
        self.say(f"turn the shaft {abs(turns):g} turns {way}, within {seconds:g} s")
        self.wait(seconds)

    def disc(self, rig: Rig) -> Disc:
        """The table's figures."""
        return disc_of(self._table("disc"), f"{self.where}: [disc]")

    def arrange(self, rig: Rig, setup: Setup) -> Rig:
        """As it is: whoever wrote the file has seen to it."""
        return rig

    def meet(self, port: Port) -> None:
        """Nothing: it is a real one."""

    def _table(self, step: str) -> Mapping[str, Any]:
        table = self.answers.get(step, {})
        if not isinstance(table, Mapping):
            raise UsageError(f"{self.where}: [{step}] must be a table")
        return table


def read_answers(path: Path) -> Mapping[str, Any]:
    """The answers in a TOML file. Raises UsageError where it is none."""
    return tables_of(read_text(path, "a file of answers", UsageError), str(path), UsageError)


def reference_of(table: Mapping[str, Any], where: str) -> Reference:
    """A meter (``meter``, ``serial``, ``accuracy``) or a resistor (``resistor_ohm``, ...)."""
    name, serial = str(table.get("meter", "")), str(table.get("serial", ""))
    if "resistor_ohm" in table:
        ohm = _number(table["resistor_ohm"], f"{where} resistor_ohm")
        limit = _number(table.get("resistor_limit_ohm", 0), f"{where} resistor_limit_ohm")
        if ohm <= 0 or limit <= 0:
            raise UsageError(f"{where}: resistor_ohm and resistor_limit_ohm must be above 0")
        return Resistor(str(table.get("resistor", "")), serial, ohm, limit / RECTANGULAR)
    if "accuracy" not in table:
        raise UsageError(f'{where}: write accuracy = "0.5%+0.003" of the meter, or resistor_ohm')
    return meter(name, serial, str(table["accuracy"]))


def disc_of(table: Mapping[str, Any], where: str) -> Disc:
    """A disc from a table with the fields of Disc. Raises UsageError where one is missing."""
    needed = ("mass_kg", "mass_uncertainty_kg", "diameter_m", "diameter_uncertainty_m")
    figures = {}
    for key in (*needed, "bore_m", "bore_uncertainty_m"):
        if key not in table and key in needed:
            raise UsageError(f"{where}: {key} is missing")
        figures[key] = _number(table.get(key, 0.0), f"{where} {key}")
    if min(figures["mass_kg"], figures["diameter_m"]) <= 0:
        raise UsageError(f"{where}: mass_kg and diameter_m must be above 0")
    return Disc(**figures)


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise UsageError(f"{where} must be a number, not {value!r}")
    return float(value)
