"""The recorded answers: one JSON file a case, a path a line, numbers with all their bits."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass

from tests.frozen.cases import ANSWERS
from tests.frozen.compare import part
from tests.frozen.flat import Flat

SHARPEST, WIDEST = 1e-6, 1e-2  # in the units of ``compare``
MARGIN = 100.0  # other kernels of the linear algebra move a case by up to so much more: 42 seen


@dataclass(frozen=True)
class Answer:
    """``moves``: by how much rounding moved each part of the answer when it was recorded
    (``perturb``), in the units of ``compare``; infinite: a word changed.
    """

    values: Flat
    moves: Mapping[str, float]

    @property
    def most(self) -> float:
        """The greatest of the moves."""
        return max(self.moves.values(), default=0.0)

    def tolerance(self, path: str) -> float:
        """What another machine may differ by: MARGIN times what rounding does, in 1e-6 to .01."""
        return min(max(MARGIN * self.moves.get(part(path), 0.0), SHARPEST), WIDEST)


def load(name: str) -> Answer:
    """The answer recorded for a case."""
    stored = json.loads((ANSWERS / f"{name}.json").read_text(encoding="utf-8"))
    return Answer(stored["values"], {name: float(moves) for name, moves in stored["moves"].items()})


def save(name: str, answer: Answer) -> None:
    """Sorted by path. ``moves`` are rounded up to a power of ten: they say no more."""
    moves = {name: f"{_power(moves):.0e}" for name, moves in answer.moves.items() if moves}
    stored = {"moves": moves, "values": answer.values}
    text = json.dumps(stored, indent=1, ensure_ascii=False, sort_keys=True, allow_nan=False)
    ANSWERS.mkdir(exist_ok=True)
    (ANSWERS / f"{name}.json").write_text(text + "\n", encoding="utf-8")


def _power(moves: float) -> float:
    return 10.0 ** math.ceil(math.log10(moves)) if math.isfinite(moves) else moves
