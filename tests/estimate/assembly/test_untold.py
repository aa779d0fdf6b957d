"""What data cannot reveal, beside a model that shows it."""

from __future__ import annotations

from motorid.estimate.assembly import untold
from motorid.estimate.results.estimate import Suspect


def suspect(code: str, strength: str = "not excluded") -> Suspect:
    return Suspect(code, "friction", "", "", strength)


def test_what_a_better_model_shows_is_no_longer_hidden() -> None:
    drift, load, named = suspect("friction_drift"), suspect("load_friction"), suspect("x", "named")
    found = (drift, load, named)
    assert untold.beside(found, ("friction-drift", "stribeck")) == (load, named)
    assert untold.beside(found, ()) == found
    same = suspect("friction_drift", "named")
    assert untold.beside((same,), ("friction-drift",)) == (same,)
