"""Which influence quantities are unknowns of a capture, and which its budget carries."""

from __future__ import annotations

from collections.abc import Iterable, Sequence, Set
from dataclasses import replace

from motorid.estimate.effects.influence_quantity import Instance, Subject, Use, instances
from motorid.estimate.effects.registry import used
from motorid.estimate.solver.problem import Unknown

Pairs = list[tuple[Instance, Unknown]]


def there(found: Iterable[Instance], subject: Subject) -> Pairs:
    """Those of these that are there, as a search takes them."""
    each = ((one, one.unknown(subject)) for one in found)
    return [(one, unknown) for one, unknown in each if unknown is not None]


def of_use(use: Use, subject: Subject) -> Pairs:
    """All that a fit of the capture uses so."""
    return there((one for q in used(use) for one in instances(q, subject)), subject)


def renewed(
    pairs: Iterable[tuple[Instance, Unknown]], subject: Subject, found: Set[Instance]
) -> Sequence[Unknown]:
    """Priors follow what drives the motor, but of those that were ``found``; starts and bounds
    stay.
    """
    out = []
    for one, unknown in pairs:
        prior = None if one in found else one.quantity.prior(subject, one.place)
        if prior is not None:
            unknown = replace(unknown, prior_mean=prior.mean, prior_sd=prior.sd)
        out.append(unknown)
    return out
