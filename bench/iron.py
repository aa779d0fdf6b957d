"""What the six parameters lack, as benches draw it: iron, windage, friction that follows load."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

EFFECTS = ("reaction", "saturation", "eddy", "windage", "load friction")
MECHANICAL = ("windage", "load friction")
TERMS = {
    "reaction": "armature-reaction",
    "saturation": "saturation",
    "eddy": "eddy",
    "windage": "quadratic-load",
    "load friction": "load-friction",
}
"""The wider model's term for each."""


@dataclass(frozen=True)
class Iron:
    """Shares are of the value at no current or no-load speed."""

    reaction: float = 0.0  # of K, lost at the stall current
    bend: float = 0.1  # of the stall current, over which that sets in
    saturation: float = 0.0  # of dλ/di, lost at the stall current
    eddy: float = 0.0  # of L, beside a resistance
    eddy_s: float = 1e-4
    windage: float = 0.0  # quadratic over viscous torque at no-load speed
    load_friction: float = 0.0  # of |K i|
    ripple: float = 0.0  # of K, amplitude
    ripple_per_turn: int = 10


def draw_iron(rng: np.random.Generator, names: tuple[str, ...] = EFFECTS) -> Iron:
    """One, two or three of these effects, of the sizes that real motors have."""
    sizes = {
        "reaction": {"reaction": rng.uniform(0.02, 0.1), "bend": rng.uniform(0.02, 0.5)},
        "saturation": {"saturation": rng.uniform(0.2, 0.55)},
        "eddy": {"eddy": rng.uniform(0.3, 0.5), "eddy_s": 10 ** rng.uniform(-4.52, -3.52)},
        "windage": {"windage": rng.uniform(0.1, 0.5)},
        "load friction": {"load_friction": rng.uniform(0.01, 0.05)},
    }
    chosen = rng.choice(names, size=min(int(rng.integers(1, 4)), len(names)), replace=False)
    return Iron(**{k: float(v) for name in chosen for k, v in sizes[str(name)].items()})


def present(iron: Iron) -> tuple[str, ...]:
    """The names of EFFECTS that it has."""
    sizes = asdict(iron)
    return tuple(name for name in EFFECTS if sizes[name.replace(" ", "_")])
