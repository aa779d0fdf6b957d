"""A better model beside the six parameters: what it says, and what speaks for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from motorid.estimate.results.estimate import Parameter


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
