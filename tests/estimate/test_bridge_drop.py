"""What a fit says of R and L behind a bipolar bridge, whose drop bends within a reading."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from motorid import fit
from motorid.acquire import record
from motorid.capture import store
from motorid.estimate.results.status import Status
from motorid.workflow.kit import Answers, kit

URL = (
    "sim://?motor=maxon-amax22&speed=max&bridge_drop=1.4&bridge_resistance=1.15&supply=13"
    "&heating=no&ambient=25&counts_per_turn=44&gain_error=0&voltage_gain_error=0"
    "&aperture=250e-6&voltage_aperture=250e-6&current_filter=22e-6&voltage_filter=58.8e-6&burst=1"
)
SAID = Answers("other", URL, "l298n", "acs712-05", 44, 13.0, "x", 12.0, resistance_ohm=6.0)
TRUE = {"R": 5.53, "L": 363e-6}


BEFORE_IT = (
    "sim://?motor=dunkermotoren-gr42&speed=max&bridge_drop=1.4&bridge_resistance=1.15&supply=26"
    "&heating=no&ambient=25&counts_per_turn=512&gain_error=0&voltage_gain_error=0&burst=1"
    "&aperture=250e-6&voltage_aperture=250e-6"
)


@pytest.mark.slow
def test_where_the_supply_is_read_the_bridge_s_drop_is_a_quantity_of_its_own(
    tmp_path: Path,
) -> None:
    """It is not the motor's brushes that drop it, and the budget has its line."""
    said = Answers("other", BEFORE_IT, "l298n", "acs712-05", 512, 26.0, "x", 24.0,
                   resistance_ohm=6.0, no_load_rpm=4100.0)  # fmt: skip
    rig = kit(said, "kit", "").rig
    channels = ("current", "supply_voltage", "position")
    rig = replace(rig, sampling=replace(rig.sampling, channels=channels))
    capture = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    found = fit(capture, model="six")
    for name, true in (("bridge drop", 1.4), ("brush drop", 0.0)):
        low, high = found.nuisance[name].interval_95
        assert low <= true <= high, name
    assert found.nuisance["bridge drop"].total < 0.3  # as declared; the current's bend tells more
    assert found.brushes is not None
    assert abs(found.brushes.drop_v) < 0.3
    assert found.budget["R"]["bridge drop"] > 0.0
    for name, true in (("R", 5.95), ("K", 0.0514), ("J", 7.1e-6)):
        low, high = found.parameters[name].interval_95 or (0.0, 0.0)
        assert low <= true <= high, name
    blind = fit(replace(capture, wiring=replace(capture.wiring, bridge_drop_v=0.0)), model="six")
    assert blind.nuisance["brush drop"].value == pytest.approx(1.4, abs=0.1)


@pytest.mark.slow
def test_what_the_drop_could_have_moved_is_doubtful(tmp_path: Path) -> None:
    rig = kit(SAID, "kit", "").rig
    steps = tuple(replace(one, duration_s=one.duration_s / 2) for one in rig.program.steps)
    program = replace(rig.program, steps=steps)  # 2.7 s show as much
    capture = store.load(record.capture(rig, program, tmp_path / "run.h5"))
    found = fit(capture)
    assert "bridge_drop" in {one.code for one in found.diagnostics}
    for name, true in TRUE.items():
        low, high = found.parameters[name].interval_95 or (0.0, 0.0)
        assert low <= true <= high, name
    assert found.parameters["L"].status is Status.DOUBTFUL
    blind = fit(replace(capture, wiring=replace(capture.wiring, bridge_drop_v=0.0)), model="six")
    assert "bridge_drop" not in {one.code for one in blind.diagnostics}
