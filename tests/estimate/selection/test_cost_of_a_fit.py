"""What the default fit costs beside the six parameters, and what it says where that is too much."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.selection import entry
from motorid.motor.tally import counting
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Sampling, load_rig
from tests.six_parameters import fit

DRIVES = tuple(
    Step(StepKind.DRIVE_VOLTS, 0.1, volts, Decay.SYNCHRONOUS_SLOW) for volts in (2.0, 5.0)
)
ONE_WAY = Program((Step(StepKind.COAST, 0.02), *DRIVES, Step(StepKind.COAST, 0.7)))
CHANNELS = ("current", "terminal_voltage", "position")
URL = "speed=max&seed=4&heating=0&stiction=1&brush_drop=0.2"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    """A motor whose friction is higher at low speed, and whose brushes drop .2 V."""
    rig = load_rig("sim")
    sampling = Sampling(5000.0, CHANNELS)
    rig = replace(rig, port=f"{rig.port}&{URL}", program=ONE_WAY, sampling=sampling)
    path = tmp_path_factory.mktemp("cost") / "run.h5"
    return store.load(record(rig, rig.program, path, force=True))


def fitted(run: Capture, model: str) -> tuple[Estimate, int]:
    """And the responses that it took."""
    with counting() as count:
        return fit([run], model=model), count.responses


@pytest.mark.slow
def test_all_of_it_takes_five_times_the_six_parameters_at_most(run: Capture) -> None:
    _, six = fitted(run, "six")
    estimate, whole = fitted(run, "auto")
    assert six < whole <= 5 * six
    assert estimate.alternative is not None
    assert all(one.code != "search_ended" for one in estimate.diagnostics)


@pytest.mark.slow
@pytest.mark.parametrize("most", [1.2, 1.4])
def test_what_is_cut_is_said_and_leaves_the_six_as_they_are(
    most: float, run: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain, six = fitted(run, "six")
    monkeypatch.setattr(entry, "MOST", most)
    estimate, whole = fitted(run, "auto")
    assert whole <= most * six + 0.5 * six  # derivatives that were begun, and what is seen
    assert {n: p.value for n, p in estimate.parameters.items()} == {
        n: p.value for n, p in plain.parameters.items()
    }
    (said,) = [one for one in estimate.diagnostics if one.code == "search_ended"]
    assert "--model " in said.message
