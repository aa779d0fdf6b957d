"""A simulated bench that calibrates itself: a person who reads meters on the plant of ``sim://``."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from motorid.calibration.disc import Disc
from motorid.calibration.gain import Meter, meter
from motorid.errors import UsageError
from motorid.workflow.record import SIM, sim_url

if TYPE_CHECKING:
    from motorid.acquire.port import Port
    from motorid.rig import Rig
    from motorid.workflow.calibrate.person import Reference, Setup

ROTOR, SIZE_M = 3.9e-7, 0.02  # kg·m² of a rotor, and the diameter of a disc that suits it


@dataclass
class Simulated:
    """A bench of ``sim://`` that calibrates itself, with instruments of a stated accuracy.

    Each meter's and the disc's own error is drawn once, by ``seed``, from what it states.
    """

    say: Callable[[str], None]
    seed: int = 1
    accuracy: Mapping[str, str] = field(
        default_factory=lambda: {
            "current": "0.2%+0.001",
            "terminal_voltage": "0.05%+0.001",
            "supply_voltage": "0.05%+0.001",
        }
    )
    settings: tuple[float, ...] = (0.75, 1.0, 1.2)  # of the supply, over its nominal voltage

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)  # noqa: S311 - errors, not secrets
        self._errors = {
            step: self._draw(self._meter(step).of_reading) for step in sorted(self.accuracy)
        }
        self._meters: Any = None
        self._nominal_v = 0.0
        self._disc = Disc(1.0, 0.0, 1.0, 0.0)
        self._heavier, self._wider = self._random.gauss(0, 1), self._random.gauss(0, 1)

    def ready(self, step: str, what: str) -> bool:
        """Always."""
        return True

    def proceed(self, what: str) -> None:
        """Says it and goes on."""
        self.say(what)

    def again(self, step: str, problem: str) -> bool:
        """Never."""
        return False

    def reference(self, step: str) -> Reference:
        """A simulated meter."""
        return self._meter(step)

    def _meter(self, step: str) -> Meter:
        return meter("simulated meter", f"{step}-{self.seed}", self.accuracy[step])

    def _draw(self, limit: float) -> float:
        return self._random.uniform(-limit, limit)

    def reading(self, step: str, number: int, what: str) -> float:
        """What the simulated meter shows, with its own error."""
        shown: float
        if step == "supply_voltage":
            self._meters.set_supply(self.settings[number] * self._nominal_v)
            shown = self._meters.settled_supply()
        else:
            shown = self._meters.read(step)
        return shown + self._draw(self._meter(step).absolute)

    def levels(self, step: str) -> int:
        """Three settings of the supply."""
        return len(self.settings)

    def turn(self, turns: float) -> None:
        """By a hand that stops up to two degrees off."""
        self._meters.turn(turns + self._draw(2 / 360))

    def disc(self, rig: Rig) -> Disc:
        """A disc about as heavy as the rotor: what is stated of it."""
        inertia = rig.nameplate.inertia_kg_m2 or ROTOR
        size = SIZE_M * (inertia / ROTOR) ** 0.2
        mass = 8 * inertia / size**2
        self._disc = Disc(mass, 2e-3 * mass, size, 1e-3 * size)
        return self._disc

    def arrange(self, rig: Rig, setup: Setup) -> Rig:
        """The simulated bench clamps its shaft, or puts a disc on it, by itself."""
        self._nominal_v = rig.supply_voltage_v or rig.limits.supply_max_v
        if not rig.port.startswith(SIM):
            raise UsageError(f"--simulated is for sim:// rigs, and this one is at {rig.port}")
        match setup:
            case "load":
                return replace(rig, port=sim_url(rig.port, fault="stall"))
            case "disc":
                true = replace(
                    self._disc,
                    mass_kg=self._disc.mass_kg + self._heavier * self._disc.mass_uncertainty_kg,
                    diameter_m=self._disc.diameter_m
                    + self._wider * self._disc.diameter_uncertainty_m,
                )
                return replace(rig, port=sim_url(rig.port, load_inertia=repr(true.inertia)))
        return rig

    def meet(self, port: Port) -> None:
        """Clips its meters on."""
        from motorid.sim.meters import Meters
        from motorid.sim.port import SimPort

        if isinstance(port, SimPort):
            self._meters = Meters(port, self._errors)
