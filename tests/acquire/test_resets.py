"""A reset is noticed at any time: by the greeting or, when that is lost, by the boot id."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from motorid.acquire import record
from motorid.acquire.resets import BoardResetError
from motorid.capture import store
from motorid.program import Program
from tests.acquire.rigs import SHORT, sim_rig

LONG = Program(SHORT.steps * 4)


def capture(fault: str, path: Path) -> BoardResetError:
    rig = sim_rig(f"fault={fault}", program=LONG)
    with pytest.raises(BoardResetError) as caught:
        record.capture(rig, rig.program, path)
    return caught.value


@pytest.mark.slow
@pytest.mark.parametrize("lost", ["", ",mute@{0}..{1}"], ids=["greeted", "greeting lost"])
@pytest.mark.parametrize("at_s", [0.02, 0.1, 0.2, 0.3, 0.45, 0.7, 1.1, 1.6])
def test_a_reset_is_noticed(at_s: float, lost: str, tmp_path: Path) -> None:
    """From the check pulse, over loading, to the last step of the run."""
    mute = lost.format(round(at_s - 0.001, 4), round(at_s + 0.004, 4))
    error = capture(f"reset@{at_s}{mute}", tmp_path / "run.h5")
    assert "the board was reset" in str(error)
    assert "(external)" in str(error)
    assert "another program opened its port" in str(error)
    assert error.exit_code == 3
    if (tmp_path / "run.h5").exists():
        assert store.load(tmp_path / "run.h5").end_reason == "reset: external"


@pytest.mark.slow
def test_a_burst_that_is_lost_to_a_reset_is_noticed(tmp_path: Path) -> None:
    rig = sim_rig("fault=reset@0.5,mute@0.499..0.504&buffer=4000")
    rig = replace(rig, sampling=replace(rig.sampling, mode="burst"))
    with pytest.raises(BoardResetError):
        record.capture(rig, rig.program, tmp_path / "run.h5")


@pytest.mark.slow
def test_samples_that_do_not_come_do_not_end_a_run(tmp_path: Path) -> None:
    """Nothing heard for 0.7 s of 1.5: the run goes on, and the file says what is missing."""
    rig = sim_rig("fault=mute@0.6..1.3", program=LONG)
    kept = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    assert kept.end_reason == "completed"
    assert 6000 < sum(gap.samples for gap in kept.gaps) == 15_200 - len(kept)
