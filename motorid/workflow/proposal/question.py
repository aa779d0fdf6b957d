"""What a person has said of a file, and what still has to be asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from motorid.capture.mapping import stated
from motorid.errors import UsageError


@dataclass(frozen=True)
class Known:
    """Stated by a person, and never guessed again.

    ``columns``: quantity -> column or arithmetic, "" to leave the quantity out. ``units``: quantity
    -> unit. ``counts_per_turn`` 0: not stated. ``sense`` of the voltage, "": not stated.
    ``as_it_stands``: what no motor has was confirmed. ``geared``: a gear was stated.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    counts_per_turn: float = 0.0
    sense: str = ""
    as_it_stands: bool = False
    geared: bool = False

    def and_(self, more: Known) -> Known:
        """With what else was said."""
        return replace(
            self,
            columns={**self.columns, **more.columns},
            units={**self.units, **more.units},
            counts_per_turn=more.counts_per_turn or self.counts_per_turn,
            sense=more.sense or self.sense,
            as_it_stands=more.as_it_stands or self.as_it_stands,
            geared=more.geared or self.geared,
        )


NOTHING = Known()


def of_maps(maps: tuple[str, ...]) -> Known:
    """What ``--map QUANTITY=COLUMN:UNIT`` say. Raises UsageError as ``mapping.stated``."""
    said = stated(maps)
    return Known(
        {quantity: column for quantity, (column, _) in said.items()},
        {quantity: unit for quantity, (_, unit) in said.items()},
    )


@dataclass(frozen=True)
class Answer:
    """One that may be chosen; ``option``: how to say it on the command line."""

    text: str
    known: Known
    option: str


@dataclass(frozen=True)
class Question:
    """``number``: what a number as an answer stands for, None where none is asked for.

    ``formula`` holds ``{}`` for that number.
    """

    text: str
    answers: tuple[Answer, ...] = ()
    number: str | None = None
    quantity: str = ""  # whose expression a number completes; "counts": counts per turn
    formula: str = "{}"
    unit: str = ""

    def of_number(self, value: float) -> Known:
        """What that number says. Raises UsageError for one that is not above zero."""
        if not value > 0:
            raise UsageError(f"{value:g}: give a number above zero")
        if self.quantity == "counts":
            return Known(counts_per_turn=value)
        expression = self.formula.format(f"{value:.12g}")
        return Known({self.quantity: expression}, {self.quantity: self.unit})

    @property
    def options(self) -> list[str]:
        """How to answer on the command line."""
        said = [answer.option for answer in self.answers]
        if self.number is not None:
            said.append(
                "--counts-per-turn NUMBER"
                if self.quantity == "counts"
                else f"--map {self.quantity}={self.formula.format('NUMBER')}:{self.unit}"
            )
        return [one for one in said if one]
