"""How many mutants of a room were killed, against its goal."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from tools.mutants.mutant import Mutant, equivalent
from tools.mutants.trial import Answer

CORE = "firmware"
GOALS = {"estimate": 0.85, "quality": 0.85, "acquire": 0.85, "wire": 0.85, "segment": 0.85,
         "capture": 0.85, CORE: 0.95}  # fmt: skip
MOST_EQUIVALENT = 0.1  # of a room's sample


@dataclass
class Score:
    """A room's mutants and what became of them."""

    room: str
    population: int
    answers: list[tuple[Mutant, Answer]] = field(default_factory=list)

    def of(self, *outcomes: str) -> list[Mutant]:
        """Mutants that ended so."""
        return [mutant for mutant, answer in self.answers if answer.outcome in outcomes]

    @property
    def left(self) -> list[Mutant]:
        """Those that no test noticed, and that are not called equivalent."""
        known = equivalent()
        return [m for m in self.of("survived", "uncovered") if (m.path, m.change) not in known]

    @property
    def half_tried(self) -> int:
        """Survivors that some covering tests never met: the budget was spent before."""
        answers = dict(self.answers)
        return sum(answers[m].tried < answers[m].covering for m in self.left)

    @property
    def called_equivalent(self) -> int:
        """How many survivors change no behaviour, each with its reason."""
        return len(self.of("survived", "uncovered")) - len(self.left)

    @property
    def share(self) -> float:
        """Of those that could be noticed, the share that was."""
        able = len(self.answers) - self.called_equivalent
        return len(self.of("killed")) / able if able else 0.0

    @property
    def good(self) -> bool:
        """At its goal, with few enough called equivalent."""
        few = self.called_equivalent <= MOST_EQUIVALENT * len(self.answers)
        return few and self.share >= GOALS[self.room]

    def row(self) -> str:
        """A line of the table."""
        return (
            f"{self.room:10} {len(self.answers):6} {len(self.of('killed')):7} {len(self.left):9} "
            f"{self.half_tried:10} {self.called_equivalent:11} {self.share:7.0%} "
            f"{GOALS[self.room]:5.0%}"
        )

    def as_json(self) -> dict[str, Any]:
        """For the file of results."""
        answers = dict(self.answers)
        return {
            "population": self.population,
            "tried": len(self.answers),
            "killed": len(self.of("killed")),
            "survived": len(self.left),
            "survived_part_of_their_tests": self.half_tried,
            "equivalent": self.called_equivalent,
            "share_killed": round(self.share, 4),
            "goal": GOALS[self.room],
            "survivors": [
                {
                    "file": mutant.path,
                    "line": mutant.line,
                    "operator": mutant.operator,
                    "change": mutant.change,
                    "tests_tried": answers[mutant].tried,
                    "tests_covering": answers[mutant].covering,
                }
                for mutant in self.left
            ],
        }


HEAD = "room        tried  killed  survived  half-tried  equivalent   share  goal"
