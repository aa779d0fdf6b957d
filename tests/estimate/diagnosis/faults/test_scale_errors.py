"""Scale errors: how they move the parameters, and what a nameplate or a disc tells of them."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from motorid.capture.model import CURRENT, POSITION, VOLTAGE
from motorid.estimate.diagnosis.faults import scale_errors
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status
from motorid.identify import fit
from tests.estimate.diagnosis.faults import inject
from tests.estimate.diagnosis.faults.cases import SCALES, Case, Runs
from tests.estimate.diagnosis.faults.rigs import DUTIES, Bench, without_nameplate
from tests.exact_capture import FAULHABER, Plan, clean_capture

FACTOR = 1.25


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    return Runs(Bench("qube-servo", 2, DUTIES, tmp_path_factory.mktemp("rig")))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("channel", "cause"),
    [
        (POSITION, scale_errors.SPEED),
        (CURRENT, scale_errors.AMPERES),
        (VOLTAGE, scale_errors.VOLTS),
    ],
)
def test_the_powers_are_those_of_the_fit(channel: str, cause: scale_errors.Cause) -> None:
    """A capture of the exact model with one channel scaled fits as well, with these powers."""
    good = clean_capture(FAULHABER, Plan(volts=(6.0, 3.0), count=3000))
    before, after = (fit([c]).parameters for c in (good, inject.scaled(good, channel, FACTOR)))
    for name in ("R", "L", "K", "B", "J", "T0"):
        a, b = before[name].value, after[name].value
        assert a is not None
        assert b is not None
        assert b / a == pytest.approx(FACTOR ** cause.powers.get(name, 0), rel=5e-3), name


def test_a_factor_is_the_mean_that_its_figures_give_by_their_certainty() -> None:
    """A speed 1.5 times too large by K, which is better known, and 1.4 times by J."""
    by_k, by_j = math.log(1.5), math.log(1.4)
    known = {
        "R": (0.0, 0.08), "L": (0.0, 0.3), "K": (-by_k, 0.05), "J": (-2.0 * by_j, 0.2),
    }  # fmt: skip
    (found,) = scale_errors.by_nameplate(known)
    assert found.cause is scale_errors.SPEED
    weights = 1.0 / 0.05**2, 4.0 / 0.2**2
    mean = (weights[0] * by_k + weights[1] * by_j) / sum(weights)
    assert math.log(found.factor) == pytest.approx(mean, abs=1e-9)


@pytest.mark.parametrize(
    ("cause", "current", "speed", "voltage"),
    [
        (scale_errors.AMPERES, 1, 0, 0),
        (scale_errors.SPEED, 0, 1, 0),
        (scale_errors.VOLTS, 0, 0, 1),
    ],
)
def test_scaled_readings_obey_both_laws_of_the_motor(
    cause: scale_errors.Cause, current: int, speed: int, voltage: int
) -> None:
    """V = R i + L di/dt + K ω and K i = J dω/dt + B ω + T0, each term by the same power."""
    of = {name: cause.powers.get(name, 0) for name in ("R", "L", "K", "B", "J", "T0")}
    assert {of["R"] + current, of["L"] + current, of["K"] + speed} == {voltage}
    assert {of["J"] + speed, of["B"] + speed, of["T0"]} == {of["K"] + current}


@pytest.mark.parametrize(
    ("cause", "speed"), [(scale_errors.TIME_OF_SPEED, 0), (scale_errors.TIME_OF_POSITION, -1)]
)
def test_a_stretched_time_obeys_both_laws_of_the_motor(
    cause: scale_errors.Cause, speed: int
) -> None:
    """A derivative is divided by the factor; a speed that a position gives is one."""
    of = {name: cause.powers.get(name, 0) for name in ("R", "L", "K", "B", "J", "T0")}
    assert {of["R"], of["L"] - 1, of["K"] + speed} == {0}
    assert {of["J"] + speed - 1, of["B"] + speed, of["T0"]} == {of["K"]}


def test_what_leaves_no_trace_is_listed_by_what_was_read() -> None:
    """The scales and the clock."""
    fitted = {"J": Parameter("J", "", 4e-7, 0.0, 0.0, 4e-9, None, Status.ESTIMATED)}
    listed = {s.code: s for s in scale_errors.suspects(fitted, {}, turned=False)}
    assert {"time_scale", "speed_scale"} <= set(listed)
    assert {s.strength for s in listed.values()} == {"not excluded"}


def test_leads_add_resistance_and_never_take_any_away() -> None:
    plate = {"R": 2.6, "L": 180e-6, "K": 7.68e-3, "J": 3.9e-7}
    fitted = {
        name: Parameter(name, "", value, 0.0, 0.0, 0.01 * value, None, Status.ESTIMATED)
        for name, value in plate.items()
    }

    def said(ohms: float) -> dict[str, str]:
        R = replace(fitted["R"], value=ohms, total=0.01 * ohms)
        return {s.code: s.evidence for s in scale_errors.suspects({**fitted, "R": R}, plate)
                if s.strength == "named"}  # fmt: skip

    assert "about 5.2 ohm are in series" in said(7.8)["series_resistance"]
    assert "series_resistance" not in said(0.8)


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (4.0, "the encoder's counts per turn are set four times too low: lines for counts"),
        (0.25, "the encoder's counts per turn are set four times too high"),
        (1.3, "the encoder or speed reads 1.3 times what is true"),
    ],
)
def test_a_factor_has_its_usual_name_or_is_told(factor: float, words: str) -> None:
    assert scale_errors.SPEED.words(factor) == words


SLOW = {  # L is lost, and looked for; or the fit has no motor to find
    "mA for A": [pytest.mark.slow],
    "voltage gain": [pytest.mark.slow],
    "mV for V": [pytest.mark.slow, pytest.mark.long],
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(
            c,
            marks=SLOW.get(c.name, []),
            id=c.name,
        )
        for c in SCALES
    ],
)
def test_a_nameplate_names_the_scale(case: Case, runs: Runs) -> None:
    """And without one, of the same fit, no scale is excluded."""
    estimate = fit([case.capture(runs)])
    bare = scale_errors.suspects(estimate.parameters, {})
    hidden = {s.code for s in bare if s.strength == "not excluded"}
    assert hidden == {c.code for c in (*scale_errors.CAUSES, scale_errors.TIME_OF_POSITION)}
    found = [s for s in estimate.suspects if s.code in hidden]
    assert [(s.code, s.strength) for s in found] == [(case.code, "named")]


def test_a_rig_that_says_nothing_of_its_motor_excludes_no_scale(runs: Runs) -> None:
    scales = {c.code for c in scale_errors.CAUSES}
    bare = [s for s in fit([without_nameplate(runs.good)]).suspects if s.code in scales]
    assert {s.code for s in bare} == scales
    assert {s.strength for s in bare} == {"not excluded"}


@pytest.mark.slow
@pytest.mark.parametrize("options", ["", "&magnet=1.06&copper=0.93", "&load_inertia=8e-6"])
def test_a_motor_within_its_tolerance_is_not_blamed(options: str, tmp_path: Path) -> None:
    """Nor is a load on its shaft."""
    estimate = fit([Bench("qube-servo", 4, DUTIES, tmp_path).capture(options)])
    assert all(s.strength == "not excluded" for s in estimate.suspects)
    scales = {c.code for c in scale_errors.CAUSES}
    assert all("below a factor of" in s.evidence for s in estimate.suspects if s.code in scales)


def inertia(value: float) -> Parameter:
    u = 0.002 * value
    return Parameter(
        "J", "kg·m²", value, u, 0.0, u, (value - 2 * u, value + 2 * u), Status.ESTIMATED
    )


@pytest.mark.parametrize(
    ("factor", "code"),
    [
        (1 / 4, "speed_scale"),  # counts per turn x 2
        (1 / 16, "speed_scale"),
        ((6.283185307 / 60) ** 2, "speed_scale"),
        (1e3, "current_scale or voltage_scale"),  # either makes the same of a disc
        (1.2, "gain"),
    ],
)
def test_a_disc_names_the_scale(factor: float, code: str) -> None:
    rotor, disc = 4e-6, 1e-5
    pair = inertia(rotor * factor), inertia((rotor + disc) * factor)
    found = scale_errors.by_disc(*pair, disc, 0.002 * disc)
    assert [s.code for s in found] == [code]


def test_a_disc_that_fits_blames_nothing() -> None:
    assert scale_errors.by_disc(inertia(4e-6), inertia(1.401e-5), 1e-5) == ()


def test_millivolts_are_told_by_the_readings_where_the_fit_is_bad() -> None:
    """So far off, K may come out as if the current were in mA; the voltage itself does not."""
    plate = {"R": 2.6, "L": 180e-6, "K": 7.68e-3, "J": 3.9e-7, "V": 6.0}
    units = {"R": "ohm", "L": "H", "K": "N·m/A", "J": "kg·m²"}
    fitted = {
        n: Parameter(n, u, f * plate[n], 0.0, 0.0, 0.0, None, Status.ESTIMATED)
        for (n, u), f in zip(units.items(), (990.0, 980.0, 1.05, 0.9e-3), strict=True)
    }
    assert [s.code for s in scale_errors.suspects(fitted, plate, 6.0)] == ["current_scale"]
    assert [s.code for s in scale_errors.suspects(fitted, plate, 5980.0)] == ["voltage_scale"]
