"""Delays known only so well: told by the fit where the data tell them, else part of the budget."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import CURRENT, Capture
from motorid.estimate.fit import start_values
from motorid.estimate.fit.alternating_fit import with_sources
from motorid.estimate.fit.multistart import whitened
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS, Parameter
from motorid.estimate.uncertainty import budget
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import load_rig
from motorid.sim.chain import draw_chain
from motorid.sim.options import parse_url
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit

LATE_S = 3e-7


def declared(capture: Capture, delay_s: float, uncertainty_s: float) -> Capture:
    """The same capture whose current's delay is declared so."""
    current = replace(capture.channels[CURRENT], delay_s=delay_s, delay_uncertainty_s=uncertainty_s)
    return replace(capture, channels={**capture.channels, CURRENT: current})


def known(p: Parameter) -> tuple[float, float]:
    """Value and standard uncertainty."""
    assert p.value is not None
    assert p.total is not None
    return p.value, p.total


def instants(folder: Path, query: str) -> tuple[Capture, str]:
    """Two levels of the simulated rig with an instant current amid ripple; its port."""
    rig = load_rig("sim")
    rig = replace(rig, port=f"{rig.port}&speed=max&aperture=0&delay=0&phase=0.3&{query}")
    slow = Decay.SYNCHRONOUS_SLOW
    drives = [Step(StepKind.DRIVE_DUTY, 0.05, duty, slow) for duty in (0.4, 0.85)]
    steps = (Step(StepKind.COAST, 0.03), *drives, Step(StepKind.COAST, 0.2))
    return store.load(record(rig, Program(steps), folder / "run.h5")), rig.port


def shares(capture: Capture) -> tuple[dict[str, float], dict[str, float]]:
    """A fit that takes the delay as declared: every parameter, and what the delay's uncertainty
    does to it, both in search coordinates.
    """
    records = [MotorRecord(capture, PARAMETERS, {})]
    start = start_values.start_values(records, {})
    solution = whitened(records, PARAMETERS, start, with_sources(records, PARAMETERS, start))
    moved = budget.propagated(solution, records).get("current delay", np.zeros(len(PARAMETERS)))
    values = (np.log(v) if u.log else v for u, v in
              zip(solution.unknowns, solution.values, strict=True))  # fmt: skip
    return dict(zip(PARAMETERS, values, strict=True)), dict(zip(PARAMETERS, moved, strict=True))


def test_an_uncertain_delay_moves_the_answer_as_a_wrong_one_does() -> None:
    clean = clean_capture(FAULHABER, Plan())
    capture = noisy(clean, 3, 1e-3, 1e-4)
    true_s = capture.channels[CURRENT].delay_s
    right, share = shares(declared(capture, true_s, LATE_S))
    wrong, none = shares(declared(capture, true_s - LATE_S, 0.0))
    assert abs(share["L"]) == pytest.approx(abs(wrong["L"] - right["L"]), rel=0.05)
    assert abs(share["L"]) > 1e-4
    assert not any(none.values())
    for name in ("K", "J"):
        assert abs(share[name]) < 1e-5


@pytest.mark.slow
def test_an_instant_that_is_later_is_one_of_another_phase_of_the_ripple(tmp_path: Path) -> None:
    """Ripple is most of what a delay changes of an instant's reading amid it."""
    capture, _ = instants(tmp_path, "seed=7")
    current = capture.channels[CURRENT]
    late_s = LATE_S / 2  # by the whole, L goes a tenth less far than straight
    right, share = shares(declared(capture, current.delay_s, late_s))
    wrong, _ = shares(moved(capture, late_s, 0.0))
    assert abs(share["L"]) == pytest.approx(abs(wrong["L"] - right["L"]), rel=0.1)
    assert abs(share["L"]) > 0.01


def moved(capture: Capture, late_s: float, uncertainty_s: float) -> Capture:
    """The same capture whose current's delay, and with it its phase, is declared to be larger."""
    current = capture.channels[CURRENT]
    phase = ((current.pwm_phase or 0.0) - late_s * capture.wiring.pwm_hz) % 1.0
    other = replace(capture.channels[CURRENT], pwm_phase=phase)
    capture = replace(capture, channels={**capture.channels, CURRENT: other})
    return declared(capture, current.delay_s + late_s, uncertainty_s)


@pytest.fixture(scope="module")
def amid_ripple(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    """Its delay is exact as declared."""
    return instants(tmp_path_factory.mktemp("ripple"), "seed=7")[0]


@pytest.mark.slow
@pytest.mark.parametrize("off", [-0.8, 1.3])
def test_a_delay_that_ripple_tells_is_found(off: float, amid_ripple: Capture) -> None:
    """Off by so many of its standard uncertainties, it costs L next to nothing."""
    exact = fit([moved(amid_ripple, 0.0, 0.0)])
    found = fit([moved(amid_ripple, -off * LATE_S, LATE_S)])
    late_s, late_u = known(found.nuisance["current delay"])
    assert late_s == pytest.approx(off * LATE_S, abs=2.5 * late_u)
    assert found.nuisance["current delay"].unit == "s"
    assert late_u < 0.2 * LATE_S
    found_h, u = known(found.parameters["L"])
    assert found_h == pytest.approx(known(exact.parameters["L"])[0], abs=2.0 * u)


@pytest.mark.slow
def test_what_is_an_unknown_is_no_propagated_cause_as_well(amid_ripple: Capture) -> None:
    found, exact = (fit([moved(amid_ripple, 0.0, u)]) for u in (LATE_S, 0.0))
    assert "current delay" not in exact.nuisance
    _, share = shares(moved(amid_ripple, 0.0, LATE_S))
    (L, u), (_, least) = (known(e.parameters["L"]) for e in (found, exact))
    assert found.budget["L"]["current delay"] < 0.1 * abs(share["L"]) * L
    assert least < u < 0.5 * np.hypot(least, share["L"] * L)


@pytest.mark.slow
def test_a_wider_model_finds_the_delay_as_well(amid_ripple: Capture) -> None:
    found = fit([moved(amid_ripple, -1.3 * LATE_S, LATE_S)], model="quadratic-load")
    assert found.alternative is not None
    late_s, u = known(found.alternative.nuisance["current delay"])
    assert late_s == pytest.approx(1.3 * LATE_S, abs=2.5 * u)
    assert u < 0.2 * LATE_S


@pytest.mark.slow
def test_a_delay_beyond_its_declaration_stays_as_declared(amid_ripple: Capture) -> None:
    """What the data show is then something else's doing, and no unknown hides it."""
    found = fit([moved(amid_ripple, -8.0 * LATE_S, LATE_S)])
    assert "current delay" not in found.nuisance
    assert found.budget["L"]["current delay"] > 0.0


@pytest.mark.slow
def test_a_delay_that_only_a_step_tells_stays_as_declared() -> None:
    """Means without ripple: the voltage is least sure where they would determine it."""
    capture = noisy(clean_capture(FAULHABER, Plan()), 3, 1e-3, 1e-4)
    found = fit([declared(capture, capture.channels[CURRENT].delay_s, LATE_S)])
    assert "current delay" not in found.nuisance
    assert found.budget["L"]["current delay"] > 0.0


@pytest.mark.slow
def test_the_simulated_boards_delays_are_found_within_what_is_stated(tmp_path: Path) -> None:
    """A simulator whose physics the fit does not share draws them from what is declared."""
    off = []
    for seed in range(1, 6):
        stated_s = 1e-6
        capture, port = instants(tmp_path, f"seed={seed}&delay_uncertainty={stated_s}")
        current = capture.channels[CURRENT]
        true_s = draw_chain(parse_url(port)).current.true_delay_s - current.delay_s
        found = fit([declared(capture, current.delay_s, stated_s)])
        late_s, u = known(found.nuisance["current delay"])
        assert u < 0.2 * stated_s
        off.append((late_s - true_s) / u)
        (tmp_path / "run.h5").unlink()
    assert np.abs(off).max() < 3.0
