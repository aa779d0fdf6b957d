"""Sentences of a fit on the scale R = 1, B = 0, in the words of a log without a current.

Such a fit speaks of K, J, T0 and L, which are (K² + RB)/K, JR/K, T0·R/K and L/R there, and of the
voltage of the terminals, in whose place a command may stand. A reader of combinations has neither.
"""

from __future__ import annotations

import re

from motorid.estimate.partial.mechanical_results import CONSTANT, FRICTION, GAIN, WINDING

# powers of the parameters of that scale in what is shown
POWERS = {
    CONSTANT: {"J": 1.0, "K": -2.0},
    GAIN: {"K": -1.0},
    FRICTION: {"T0": 1.0, "K": -1.0},
    WINDING: {"L": 1.0},
}
LEAST = 0.05  # % of a change that is printed
_MOVE = r"(?:R|L|K|B|J|T0) by [+-][\d.]+%"
_MOVES = re.compile(rf"{_MOVE}(?:, {_MOVE})*")
_TOGETHER = ("J, L and the moments", "the time constant, L/R and the moments")
_VOLTS = re.compile(r"\b(the|its|The|Its) (?:terminal )?voltage\b(?!'s)")


def shown(text: str, command: bool) -> str:
    """The sentence, in combinations; with ``command`` for the voltage."""
    text = _MOVES.sub(lambda found: _combined(found[0]), text).replace(*_TOGETHER)
    return _VOLTS.sub(r"\1 command", text) if command else text


def _combined(moves: str) -> str:
    """``J by +0.3%, K by -0.1%`` as what it does to the combinations, the largest first."""
    by = {name: float(size.rstrip("%")) for name, size in
          (one.split(" by ") for one in moves.split(", "))}  # fmt: skip
    changes = {
        name: sum(power * by.get(one, 0.0) for one, power in powers.items())
        for name, powers in POWERS.items()
    }
    told = sorted(changes, key=lambda name: -abs(changes[name]))
    said = [f"{name} by {changes[name]:+.1f}%" for name in told if abs(changes[name]) >= LEAST]
    return ", ".join(said) or "no combination"
