"""A declared resistor across the motor is taken off the answer, and its uncertainty carried."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture
from motorid.estimate.effects.bridge.terminal_load import DECLARED, TERMINAL_LOAD
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from tests.estimate.effects.benches import POINT, record, start
from tests.exact_capture import FAULHABER, Plan, clean_capture, ended, noisy
from tests.six_parameters import fit

LOAD_OHM = 600.0
PLAN = Plan(volts=(6.0, -4.0, 2.0))
FINE = 20  # steps of the plant within a reading


def beside(load_ohm: float) -> Capture:
    """A motor with a resistor across it, integrated on its own; instants of all channels."""
    capture = ended(clean_capture(FAULHABER, PLAN))
    R, L, K, B, J, T0 = FAULHABER.values()
    levels, opened = _commands(capture)
    h = capture.period_s / FINE
    i = w = angle = 0.0
    rows = []
    for volts, is_open in zip(levels, opened, strict=True):
        for _ in range(FINE):
            if is_open:
                i = -K * w / (R + load_ohm)
            else:  # trapezoidal
                i = (i * (1 - h * R / (2 * L)) + h / L * (volts - K * w)) / (1 + h * R / (2 * L))
            pull = K * i - B * w
            dry = T0 * np.sign(w) if w else np.clip(pull, -T0, T0)
            after = w + h / J * (pull - dry)
            after = 0.0 if w * after < 0.0 else after
            angle, w = angle + h * (w + after) / 2, after
        v = K * w + R * i if is_open else volts
        rows.append((0.0 if is_open else i + v / load_ohm, angle, v))
    shown = dict(zip((CURRENT, POSITION, VOLTAGE), np.array(rows).T, strict=True))
    instants = {
        n: replace(c, raw=shown[n], kind="instant", aperture_s=0.0, delay_s=0.0)
        for n, c in capture.channels.items()
    }
    instants[VOLTAGE] = replace(instants[VOLTAGE], kind="mean", aperture_s=capture.period_s)
    return noisy(replace(capture, channels=instants), 1, 1e-3, 1e-4)


def _commands(capture: Capture) -> tuple[list[float], list[bool]]:
    """The level and whether the bridge is open, in the interval that ends at each tick."""
    assert capture.program is not None
    starts = [phase.tick for phase in capture.phases]
    now = np.maximum(np.searchsorted(starts, capture.ticks, side="left") - 1, 0)
    steps = [capture.program.steps[k] for k in now]
    return [s.level for s in steps], [s.level == 0.0 for s in steps]


def stating(capture: Capture, load_ohm: float, doubt_ohm: float = 0.0) -> Capture:
    wiring = replace(
        capture.wiring, terminal_load_ohm=load_ohm, terminal_load_uncertainty_ohm=doubt_ohm
    )
    return replace(capture, wiring=wiring)


def off(found: Estimate, name: str) -> float:
    """Relative."""
    return float(found.parameters[name].value or 0.0) / FAULHABER[name] - 1.0


def test_it_is_there_where_it_is_declared() -> None:
    capture = clean_capture(FAULHABER, PLAN)
    assert TERMINAL_LOAD.prior(record("measured"), 0) is None
    for doubt_ohm in (0.0, 30.0):
        subject = MotorRecord(stating(capture, LOAD_OHM, doubt_ohm), PARAMETERS, {})
        prior = TERMINAL_LOAD.prior(subject, 0)
        assert prior is not None
        relative = doubt_ohm / LOAD_OHM or DECLARED
        assert prior.sd == pytest.approx(relative / LOAD_OHM)


def test_its_tangent_is_that_of_another_resistor() -> None:
    capture = clean_capture(FAULHABER, PLAN)
    subject, more = (
        MotorRecord(stating(capture, ohms), PARAMETERS, {}) for ohms in (LOAD_OHM, LOAD_OHM / 1.01)
    )
    siemens = 0.01 / LOAD_OHM
    for one in (subject, more):
        one.retake_sources(POINT, start(one))
    moved = tangent(subject, POINT, start(subject), Instance(TERMINAL_LOAD))
    usual = subject.fitted(POINT, start(subject))
    for m, slope, before, after in zip(
        subject.measured, moved, usual, more.fitted(POINT, start(more)), strict=True
    ):
        most = np.abs(after - before).max()
        assert most > 0.0, m.block.name
        assert siemens * slope == pytest.approx(after - before, abs=0.05 * most)


@pytest.mark.slow
def test_a_fit_is_freed_of_it() -> None:
    """K² over its ohms is three tenths of B."""
    capture = beside(LOAD_OHM)
    bare, freed = fit([capture]), fit([stating(capture, LOAD_OHM, 0.01 * LOAD_OHM)])
    K, B = FAULHABER["K"], FAULHABER["B"]
    share = FAULHABER["R"] / (FAULHABER["R"] + LOAD_OHM)
    load = K**2 / (FAULHABER["R"] + LOAD_OHM) / B
    for name, by in (("R", -share), ("K", -share), ("B", load)):
        total = float(freed.parameters[name].total or 0.0) / FAULHABER[name]
        assert off(bare, name) - off(freed, name) == pytest.approx(by, rel=0.1)
        assert abs(off(freed, name)) < 4.0 * total
    carried = freed.budget["B"][TERMINAL_LOAD.name]
    assert carried == pytest.approx(0.01 * load * B, rel=0.1)


@pytest.mark.slow
def test_what_no_rig_says_is_among_what_these_data_cannot_reveal() -> None:
    capture = beside(LOAD_OHM)
    said = [s for s in fit([capture]).suspects if s.code == "terminal_load"]
    assert [s.strength for s in said] == ["not excluded"]
    assert "10 kohm would change B by -" in said[0].evidence
    assert "terminal_load_ohm" in said[0].action
    declared = fit([stating(capture, LOAD_OHM)])
    assert "terminal_load" not in [s.code for s in declared.suspects]
