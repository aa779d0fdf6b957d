"""The pieces: score test, what a look costs, direct looks, and how the report says it."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from motorid.estimate.diagnosis import rank
from motorid.estimate.diagnosis.fault import Hypothesis, Words
from motorid.estimate.diagnosis.faults import lost_samples
from motorid.estimate.diagnosis.faults.load_slip import followed
from motorid.estimate.diagnosis.faults.readings import repeated_readings
from motorid.estimate.diagnosis.score_test import Screen
from motorid.estimate.effects.brush_and_heating import lossless
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.signals.time_grid import lay
from motorid.report import html, json_, text
from tests.estimate.diagnosis.faults import inject
from tests.estimate.diagnosis.faults.cases import Runs
from tests.estimate.diagnosis.faults.rigs import DUTIES, Bench
from tests.report.example import estimate as example
from tests.six_parameters import fit

NAMED = Suspect("current_lag", "current", "the current comes 200 µs late", "declare it", "named")
HIDDEN = Suspect("speed_scale", "encoder or speed", "it leaves none", "turn it", "not excluded")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    return Runs(Bench("faulhaber-2338s006s", 2, DUTIES, tmp_path_factory.mktemp("rig")))


@pytest.mark.slow
def test_what_a_parameter_explains_scores_nothing(runs: Runs) -> None:
    """The signature is cleared of R: one that is R's own has nothing left."""
    # nuisances with a prior hold a little of a signature back: those that R resembles are left out
    records, solution = solved([lossless(runs.good)], {}, ())

    def like_resistance(record, values, own, size):  # type: ignore[no-untyped-def]
        moved = values.copy()
        moved[0] *= 1.0 + 1e-6 * size[0]
        pairs = zip(record.fitted(moved, own), record.fitted(values, own), strict=True)
        return [1e6 * (a - b) for a, b in pairs]

    words = Words("", "", "")
    same = Hypothesis("R", like_resistance, ((1.0,),), (1.0,), (-9.0,), (9.0,), lambda s: words)
    assert Screen(records, solution).best(same).gain < 1.0


@pytest.mark.slow
def test_a_good_capture_is_looked_at_once_and_nothing_is_tried(
    runs: Runs, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fit with a fault as an unknown is dear: only residuals that ask for one get it."""
    looks, fits = [], []
    usual = rank.suspects
    monkeypatch.setattr(rank, "suspects", lambda *a: looks.append(1) or usual(*a))
    monkeypatch.setattr(rank, "refit", lambda *a, **k: fits.append(1))
    estimate = fit([runs.good])
    assert len(looks) == 1
    assert not fits
    assert len(estimate.suspects) == len(list(estimate.suspects))
    assert len(looks) == 1


def test_what_follows_is_limited_and_catches_up() -> None:
    speed = np.concatenate([np.zeros(5), np.full(40, 10.0)])
    load = followed(speed, 0.5)
    assert np.diff(load).max() == pytest.approx(0.5)
    assert load[-1] == 10.0


@pytest.mark.slow
def test_missing_samples_are_told_from_lost_counts(runs: Runs) -> None:
    good = runs.good
    assert len(lost_samples.find(good, lay(good)).places) == 0
    dropped = inject.dropped(good, 3, 10, 4)
    missing = len(good) - len(dropped)
    assert lost_samples.short_of_program(dropped) == missing
    assert lost_samples.find(dropped, lay(dropped)).dropped == pytest.approx(missing, abs=6)
    lost = inject.lost_counts(good, 3, 10, 40)
    found = lost_samples.find(lost, lay(lost))
    assert found.dropped == 0
    assert len(found.places) == 10


@pytest.mark.slow
def test_every_second_reading_held_is_seen_as_such(runs: Runs) -> None:
    channel = runs.good.channels["current"]
    raw = np.repeat(np.asarray(channel.raw)[::2], 2)[: len(runs.good)]
    twice = inject.replaced(runs.good, dataclasses.replace(channel, raw=raw))
    assert [f.repeat for f in repeated_readings.find(twice)] == [2]
    assert repeated_readings.find(runs.good) == []


@pytest.mark.slow
def test_the_report_says_it() -> None:
    estimate = dataclasses.replace(example(), suspects=(NAMED, HIDDEN))
    rendered = text.render(estimate)
    assert "! The current comes 200 µs late. Declare it." in rendered
    assert "a wrong scale of encoder or speed" in " ".join(rendered.split())
    page = html.render(estimate)
    assert "The current comes 200 µs late." in page
    plain = json.loads(json_.dumps(estimate))
    jsonschema.validate(plain, json_.schema())
    assert [s["strength"] for s in plain["suspects"]] == ["named", "not excluded"]


@pytest.mark.slow
def test_a_stored_capture_is_judged_alike(runs: Runs, tmp_path: Path) -> None:
    from motorid.capture import store

    off = inject.offset(runs.good, 0.02 * runs.peak_a)
    store.save(off, tmp_path / "off.h5")
    stored, live = (
        fit([one], model="six").suspects for one in (store.load(tmp_path / "off.h5"), off)
    )
    assert stored[0].code == "current_offset"
    assert [(s.code, s.where, s.strength) for s in stored] == [
        (s.code, s.where, s.strength) for s in live
    ]
