"""What the speed alone tells of a linear motor: three numbers, where the motor has five."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt


def speed_numbers(values: Mapping[str, float]) -> dict[str, float]:
    """Of Ω/V = n0/(s² + a1 s + a0): all that the speed depends on."""
    R, L, K, B, J = (values[name] for name in ("R", "L", "K", "B", "J"))
    return {"n0": K / (J * L), "a1": R / L + B / J, "a0": (R * B + K * K) / (L * J)}


def speed_twin(values: Mapping[str, float], inductance: float, inertia_: float) -> dict[str, float]:
    """The motor with that L and J that turns exactly as this one under any voltage.

    Raises ValueError where there is none.
    """
    n0, a1, a0 = speed_numbers(values).values()
    K = n0 * inertia_ * inductance
    product = a0 * inductance * inertia_ - K * K  # R B
    total = a1 * inductance * inertia_  # R J + B L
    root = total**2 - 4.0 * product * inductance * inertia_
    if product <= 0 or root < 0:
        raise ValueError("no motor with that L and J has this speed response")
    choices = [(total + sign * sqrt(root)) / (2.0 * inertia_) for sign in (1.0, -1.0)]
    R = min(choices, key=lambda r: abs(r - values["R"]))
    return {"R": R, "L": inductance, "K": K, "B": product / R, "J": inertia_}
