"""What a fit says: values with two-part uncertainty, their standing, and the evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.results.status import Status
from motorid.look import Look
from motorid.motor.brushes import Brushes

Floats = NDArray[np.float64]
Severity = Literal["info", "warning", "error"]
Strength = Literal["named", "not excluded"]

SIX, AUTO = "six", "auto"  # models: the six parameters; and a better one where the data ask for it
PARAMETERS = ("R", "L", "K", "B", "J", "T0")
ELSEWHERE = {"K_rated": "K", "L_rated": "L", "L_1kHz": "L", "L_pwm": "L"}
"""Which of the six each is, at another current or frequency."""
UNITS = {"R": "ohm", "L": "H", "K": "N·m/A", "B": "N·m·s/rad", "J": "kg·m²", "T0": "N·m"}
MEANING = {
    "R": "resistance at the terminals, as run",
    "L": "inductance",
    "K": "torque and back-EMF constant",
    "B": "viscous friction",
    "J": "inertia",
    "T0": "Coulomb torque",
}


@dataclass(frozen=True)
class Parameter:
    """One quantity. Uncertainties are standard ones in ``unit``; ``value`` None: unknown.

    ``total`` combines ``statistical`` (noise and spread between runs) with ``instrument`` (gain,
    offset, timing, supply, rig facts). ``interval_95`` is (low, high) from the total. ``note`` says
    why a status is not "estimated", and which run would help.
    """

    name: str
    unit: str
    value: float | None
    statistical: float | None
    instrument: float | None
    total: float | None
    interval_95: tuple[float, float] | None
    status: Status
    note: str = ""


@dataclass(frozen=True)
class Diagnostic:
    """One finding about the data or the fit, as a sentence for a person and a code for a script.

    ``moves``: by how much it could have moved a parameter, in the parameter's unit (SI). Infinite:
    it can move the parameter, and nothing says how far. Parameters that it does not move are left
    out, and all of them where the fit has allowed for it. ``sides``: of a move whose way is known,
    how far below and above.
    """

    code: str
    severity: Severity
    message: str
    moves: Mapping[str, float] = field(default_factory=dict, hash=False)
    sides: Mapping[str, tuple[float, float]] = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Suspect:
    """A fault of the measuring chain: ``evidence`` for it, and the ``action`` that mends it.

    ``where`` is a channel or a part of the rig. "named": these data show it. "not excluded": it
    would leave no trace in these data. ``moves``: as of a ``Diagnostic``. ``allowed``: the fit has
    it among its unknowns, so that it spoils nothing. ``without``: then the parameters (SI) that a
    fit gives which takes the channels as stated.
    """

    code: str
    where: str
    evidence: str
    action: str
    strength: Strength
    moves: Mapping[str, float] = field(default_factory=dict, hash=False)
    allowed: bool = False
    without: Mapping[str, float] = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Curve:
    """One channel of one capture, measured against fitted, for the report. Shapes (n,)."""

    capture: int
    channel: str
    unit: str
    time_s: Floats
    measured: Floats
    fitted: Floats
    sigma: float  # standard deviation of the residual that the fit settled on
    ripple: Floats | None = None  # of ``fitted``: what the motor repeats with its rotor's angle

    @property
    def smooth(self) -> Floats:
        """What the fit shows of a motor without ripple and cogging."""
        return self.fitted if self.ripple is None else self.fitted - self.ripple


@dataclass(frozen=True)
class SteadyRow:
    """One steady-state level: means over the segment, the model's current and speed there."""

    capture: int
    start_s: float
    end_s: float
    voltage_v: float | None
    current_a: float | None
    speed_rad_s: float | None
    fitted_current_a: float | None
    foretold_speed_rad_s: float | None = None  # by the fit's own run, over the same stretch


@dataclass(frozen=True)
class MeasuredLevel:
    """One steady level as the channels showed it, of a motor that has settled there.

    By the readings alone: the fit says only with which time constant the level was approached, and
    what is left to go. Uncertainties are standard ones, of noise, approach and declared instrument
    facts. None: there is no such channel, or nobody stated its gain and offset. ``speed`` is of the
    motor's shaft. ``problem``: why the level is not to be judged.
    """

    capture: int
    start_s: float
    end_s: float
    voltage_v: float | None = None
    voltage_u: float | None = None
    speed_rad_s: float | None = None
    speed_u: float | None = None
    current_a: float | None = None
    current_u: float | None = None
    problem: str = ""


@dataclass(frozen=True)
class Repeats:
    """What the fit found to repeat ``per_turn`` times a turn of the rotor: its name and amplitude.

    Root mean square over the runs, with the standard uncertainty that noise gives.
    """

    quantity: str
    per_turn: int
    amplitude: float
    uncertainty: float
    unit: str


@dataclass(frozen=True)
class SegmentRow:
    """One stretch of a capture as the segmenter named it; ``reason`` says why it is rejected."""

    capture: int
    kind: str
    start_s: float
    end_s: float
    reason: str = ""


@dataclass(frozen=True)
class Rise:
    """How much warmer than the ambient the winding was, in the mean of the runs by I².

    K, with its standard uncertainty; ``basis`` says what it rests on, ``heat_j`` the I²R of all.
    """

    kelvin: float
    uncertainty_k: float
    heat_j: float
    basis: str


@dataclass(frozen=True)
class TermTrial:
    """One term that was fitted, and whether the data support it.

    ``gain`` of twice the log-likelihood beside the terms taken before it, less the residuals'
    colour; ``needed`` by Schwarz's criterion. ``size``: in standard deviations. ``left_out``: gain
    on captures that the fit did not see; None for a single one. ``moves``: the largest move of one
    of the six parameters, as a share of what counts.
    """

    term: str
    title: str
    beside: tuple[str, ...]
    gain: float
    needed: float
    size: float
    left_out: float | None
    moves: float
    taken: bool


@dataclass(frozen=True)
class ChannelFit:
    """Root mean square of a channel's residuals (``unit``) under both models."""

    capture: int
    channel: str
    unit: str
    before: float
    after: float


@dataclass(frozen=True)
class Alternative:
    """A wider model's answer. ``asked``: by name, whatever the data say of it.

    ``parameters`` holds R, L, K, B, J, T0, then what the terms add.
    """

    name: str
    terms: tuple[str, ...]
    titles: tuple[str, ...]
    equations: tuple[str, ...]
    asked: bool
    parameters: Mapping[str, Parameter]
    nuisance: Mapping[str, Parameter]
    chi_square: float
    degrees_of_freedom: int
    evaluations: int
    lack_of_fit: tuple[ChannelFit, ...]
    trials: tuple[TermTrial, ...] = ()
    at_25: Mapping[str, Parameter] = field(default_factory=dict)  # as of ``Estimate``


@dataclass(frozen=True)
class Estimate(Look):
    """The answer of a fit.

    ``parameters`` holds R, L, K, B, J, T0 always, in that order, then what the model adds.
    ``combinations`` are ratios such as "J/K" which the data know when the parameters alone are
    not known. ``derived`` are figures such as the no-load speed. ``nuisance`` are the offsets and
    delays estimated on the way. ``correlation`` is over ``free`` (names, in order). ``budget``
    holds, for each free parameter, the standard uncertainty in its unit that each cause gives.
    ``not_stated``: for each gain that nobody stated, how the parameters and combinations change (in
    their units) if its channel reads 1 % too much; no uncertainty holds that.
    ``at_25`` has R_25, and K_25 where the magnets' coefficient is stated: R and K at 25 °C.
    """

    model: str
    method: str
    parameters: Mapping[str, Parameter]
    combinations: Mapping[str, Parameter]
    derived: Mapping[str, Parameter]
    nuisance: Mapping[str, Parameter]
    free: tuple[str, ...]
    correlation: Floats
    chi_square: float
    degrees_of_freedom: int
    evaluations: int
    diagnostics: tuple[Diagnostic, ...]
    curves: tuple[Curve, ...] = ()
    steady: tuple[SteadyRow, ...] = ()
    segments: tuple[SegmentRow, ...] = ()
    inputs: tuple[Mapping[str, Any], ...] = ()  # path, sha256, samples, serial of each capture
    options: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    budget: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    not_stated: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    suspects: Sequence[Suspect] = ()
    alternative: Alternative | None = None  # a better model beside this answer
    at_25: Mapping[str, Parameter] = field(default_factory=dict)
    rise: Rise | None = None  # how warm the runs made the winding
    nominal_v: float | None = None  # V, at which ``derived`` is
    brushes: Brushes | None = None  # what takes of that voltage
    levels: Sequence[MeasuredLevel] = ()
    repeating: Sequence[Repeats] = ()

    __repr__ = Look.brief
