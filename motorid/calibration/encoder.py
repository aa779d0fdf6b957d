"""Counts a turn, by hand: what was counted against what the rig file says."""

from __future__ import annotations

import math
from dataclasses import dataclass

from motorid.errors import UsageError

# what people confuse: the figure counted over the figure in the rig file -> why
CONFUSED = {
    4.0: "the rig file has the lines of the disc, and the board counts four edges a line",
    2.0: "the rig file has half the counts: one channel's edges instead of both channels'",
    0.25: "the rig file has four counts a line, and the board counts only one",
    0.5: "the rig file has twice the counts that arrive: one of the two channels may be dead",
}
NEAR = 3.0  # standard uncertainties


@dataclass(frozen=True)
class Encoder:
    """Counts of one turn as counted, standard uncertainty, and what was declared."""

    per_turn: float
    uncertainty: float
    declared: float
    forwards: bool  # counted up as it was turned
    lost: float  # counts by which the way back differed from the way there

    @property
    def agrees(self) -> bool:
        """Whether the rig's figure is the one that was counted."""
        return abs(self.per_turn - self.declared) <= NEAR * self.uncertainty

    def findings(self) -> list[str]:
        """What a person should do about it, in sentences."""
        said = []
        if not self.agrees:
            said.append(
                f"one turn gives {self.per_turn:.1f} ± {self.uncertainty:.1f} counts, and "
                f"wiring.counts_per_turn is {self.declared:g}: {self._why()}"
            )
        if not self.forwards:
            said.append(
                "it counts down: if you turned it as a positive voltage does, swap A and B or "
                "change wiring.encoder_reversed"
            )
        if abs(self.lost) > 2 * NEAR * self.uncertainty:
            said.append(
                f"the way back differs by {abs(self.lost):.0f} counts: counts are lost, so look at "
                "the encoder's wires"
            )
        return said

    def _why(self) -> str:
        for factor, why in CONFUSED.items():
            if abs(self.per_turn - factor * self.declared) <= NEAR * self.uncertainty:
                return f"{why}; write {factor * self.declared:g}"
        return f"write {round(self.per_turn):d}, or turn it again more carefully"


def encoder_of(
    there: int, back: int, turns: float, declared: float, aligned_deg: float = 3.0
) -> Encoder:
    """From the counts of so many turns by hand, and of as many back to the mark.

    ``aligned_deg``: how far the mark may be off, either way, each time (limit of error). Raises
    UsageError where nothing was counted.
    """
    if turns <= 0 or not there:
        raise UsageError(
            "the encoder counted nothing while it was turned: check its wires and supply, and turn "
            "the shaft that carries it"
        )
    per_turn = (abs(there) + abs(back)) / 2 / turns if back else abs(there) / turns
    # three alignments: start, far end, start again; each in both figures that it bounds
    misplaced = aligned_deg / 360 / math.sqrt(3) * per_turn
    spread = misplaced * (math.sqrt(6) / 2 if back else math.sqrt(2))
    uncertainty = math.hypot(spread, 1 / math.sqrt(6)) / turns
    return Encoder(per_turn, uncertainty, declared, there > 0, float(there + back) if back else 0.0)
