"""Effects that these data leave to what is usual, as suspects that are not excluded.

The budget has a line for each, so that they spoil nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.results.estimate import Suspect


def suspects(untold: Sequence[InfluenceQuantity]) -> tuple[Suspect, ...]:
    """One for each."""
    return tuple(
        Suspect(
            one.name.replace(" ", "_"), one.name,
            f"these data do not show {one.name}: what is usual of it is a line of the budget",
            one.remedy, "not excluded", allowed=True,
        )
        for one in untold
    )  # fmt: skip
