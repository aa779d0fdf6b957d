"""Scale errors: how they move the parameters, and what a nameplate or a disc tells of them."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE
from motorid.capture.units import unit_of
from motorid.estimate.diagnosis.faults import scale_errors
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status
from tests.estimate.diagnosis.faults import inject
from tests.estimate.diagnosis.faults.cases import SCALES, Case, Runs
from tests.estimate.diagnosis.faults.rigs import DUTIES, Bench, without_nameplate
from tests.exact_capture import FAULHABER, Plan, clean_capture
from tests.six_parameters import fit

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


PLATE = {"R": 2.6, "L": 180e-6, "K": 7.68e-3, "J": 3.9e-7}


@pytest.mark.parametrize("factor", [0.125, 0.5, 2.0, 8.0])
@pytest.mark.parametrize(
    ("cause", "turned", "named"),
    [
        (scale_errors.TIME_OF_POSITION, True, "time_scale"),
        (scale_errors.TIME_OF_POSITION, False, None),  # a speed was read, which no clock moves
        (scale_errors.SPEED, True, "speed_scale"),
    ],
)
def test_a_clock_of_another_divider_is_told_from_wrong_counts(
    factor: float, cause: scale_errors.Cause, turned: bool, named: str | None
) -> None:
    fitted = {
        name: Parameter(
            name, "", value * factor ** cause.powers.get(name, 0), 0.0, 0.0, 1e-3 * value, None,
            Status.ESTIMATED,
        )
        for name, value in PLATE.items()
    }  # fmt: skip
    found = scale_errors.suspects(fitted, PLATE, turned=turned)
    told = [one for one in found if one.strength == "named"]
    if named is None:
        assert "time_scale" not in [one.code for one in told]
        return
    assert [one.code for one in told] == [named]
    for name, value in PLATE.items():
        off = abs((fitted[name].value or 0.0) - value)
        assert told[0].moves.get(name, 0.0) == pytest.approx(off, rel=1e-6, abs=1e-9 * value)


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


QUANTITY = {"current": CURRENT, "voltage": VOLTAGE, "speed": SPEED, "position": POSITION}
SPELT = {"degrees": "deg", "turns": "turn"}
TIMES = {"two times too low": 2.0, "four times too low": 4.0, "two times too high": 0.5,
         "four times too high": 0.25}  # fmt: skip


def test_the_usual_factors_are_those_of_the_units_that_they_name() -> None:
    for cause in scale_errors.CAUSES:
        for factor, words in cause.usual.items():
            unit = re.fullmatch(r"the (\w+) is in (\S+), read as (\S+)", words)
            if unit is None:
                (due,) = (times for said, times in TIMES.items() if said in words)
                assert factor == due
                continue
            name = QUANTITY[unit[1]]
            true, read = (unit_of(name, SPELT.get(u, u)) for u in unit.groups()[1:])
            assert factor == pytest.approx(read.scale / true.scale), words
            assert cause.words(factor * 1.1) == words
            assert cause.words(factor * 1.2) != words


def parameter(value: float | None, u: float = 0.0, status: Status = Status.ESTIMATED) -> Parameter:
    return Parameter("", "", value, u, 0.0, u, None, status)


def test_departures_are_logarithms_with_the_spread_of_motors_and_of_the_fit() -> None:
    fitted = {
        "R": parameter(3.0, 0.3), "L": parameter(None), "K": parameter(0.02, 0.0, Status.FIXED),
        "J": parameter(4e-6, 4e-7),
    }  # fmt: skip
    plate = {"R": 2.0, "L": 1e-3, "K": 0.02, "J": 2e-6}
    found = scale_errors.departures(fitted, plate)
    assert set(found) == {"R", "J"}
    assert found["R"] == pytest.approx((math.log(1.5), math.hypot(0.08, 0.1)))
    assert found["J"] == pytest.approx((math.log(2.0), math.hypot(0.15, 0.1)))


def test_a_no_load_current_is_that_of_the_friction_at_the_plates_voltage() -> None:
    K, B, T0, R, V = 0.05, 4e-5, 6e-3, 2.0, 12.0
    fitted = {n: parameter(v, 0.1 * v) for n, v in (("K", K), ("B", B), ("T0", T0), ("R", R))}
    speed = (K * V - R * T0) / (K * K + R * B)
    amperes = (T0 + B * speed) / K
    (found,) = (v for n, v in scale_errors.departures(fitted, {"V": V, "I0": 0.2}).items())
    assert found == pytest.approx((math.log(amperes / 0.2), math.hypot(0.4, 0.1)))
    assert scale_errors.departures(fitted, {"I0": 0.2}) == {}


def test_a_motor_may_run_below_its_voltage_and_not_far_above() -> None:
    assert scale_errors.departures({}, {"V": 12.0}, 11.0) == {}
    assert scale_errors.departures({}, {"V": 12.0}, 24.0)["V"] == pytest.approx(
        (math.log(2.0), 1.0)
    )
    assert not scale_errors.absurd({}, {"V": 12.0}, 12.0 * 29.0)
    assert scale_errors.absurd({}, {"V": 12.0}, 12.0 * 31.0)


def test_a_plate_is_read_as_far_as_it_has_figures() -> None:
    table = {
        "resistance_ohm": 2, "inductance_h": 1e-3, "torque_constant_nm_a": 0.05,
        "inertia_kg_m2": 0.0, "no_load_current_a": "?", "voltage_v": 12.0, "maker": "x",
    }  # fmt: skip
    assert scale_errors.read_nameplate(table) == {"R": 2.0, "L": 1e-3, "K": 0.05, "V": 12.0}


@pytest.mark.parametrize(("share", "blames"), [(0.029, False), (0.031, True), (-0.031, True)])
def test_a_disc_must_differ_by_more_than_it_is_unsure(share: float, blames: bool) -> None:
    """Three of its standard uncertainties, 0.8 % by the fits and 0.6 % by the disc."""
    without = parameter(1e-5, 0.0)
    with_disc = parameter(1e-5 + 1e-5 * math.exp(share), 0.008e-5)
    assert bool(scale_errors.by_disc(without, with_disc, 1e-5, 0.006e-5)) is blames


def test_a_disc_that_is_fitted_as_less_than_nothing_says_nothing() -> None:
    assert scale_errors.by_disc(parameter(2e-5), parameter(1e-5), 1e-5) == ()
    assert scale_errors.by_disc(parameter(None), parameter(1e-5), 1e-5) == ()
    assert scale_errors.by_disc(parameter(1e-5), parameter(None), 1e-5) == ()


def test_moves_undo_the_scale() -> None:
    verdict = scale_errors.Verdict(scale_errors.SPEED, 2.0, 0.0)
    moves = scale_errors._moves(verdict, {"K": parameter(0.05), "J": parameter(4e-6),
                                          "R": parameter(2.0), "B": parameter(None)})  # fmt: skip
    assert moves == pytest.approx({"K": 0.05 * (2.0 - 1.0), "J": 4e-6 * (4.0 - 1.0)})


SLOW = {  # L is lost, and looked for; or the fit has no motor to find
    "mA for A": [pytest.mark.slow],
    "voltage gain": [pytest.mark.study],
    "mV for V": [pytest.mark.study],
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


@pytest.mark.slow
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
    ("factor", "code", "where", "said"),
    [
        (1 / 4, "speed_scale", "encoder or speed", "set two times too low: a disc"),
        (4.0, "speed_scale", "encoder or speed", "set two times too high: a disc"),
        (1 / 16, "speed_scale", "encoder or speed", "four times too low: lines for counts: a disc"),
        ((6.283185307 / 60) ** 2, "speed_scale", "encoder or speed", "in rpm, read as rad/s: a d"),
        # either makes the same of a disc
        (1e3, "current_scale or voltage_scale", "current or voltage",
         "the current is in mA, read as A, or the voltage is in mV, read as V: a disc"),
        (1.2, "gain", "current, voltage or encoder", "square of the speed is 1.2 of it: a disc"),
    ],
)  # fmt: skip
def test_a_disc_names_the_scale(factor: float, code: str, where: str, said: str) -> None:
    rotor, disc = 4e-6, 1e-5
    pair = inertia(rotor * factor), inertia((rotor + disc) * factor)
    (found,) = scale_errors.by_disc(*pair, disc, 0.002 * disc)
    assert (found.code, found.where, found.strength) == (code, where, "named")
    assert said in found.evidence
    assert found.evidence.endswith(f"of 1e-05 kg·m² is fitted as {disc * factor:.3g} kg·m²")


@pytest.mark.parametrize(("off", "blames"), [(0.0099, False), (0.0101, True), (-0.0101, True)])
def test_a_disc_that_is_fitted_exactly_may_still_be_off_by_a_hundredth(
    off: float, blames: bool
) -> None:
    exact = parameter(0.0), parameter(1e-5 * math.exp(off))
    assert bool(scale_errors.by_disc(*exact, 1e-5)) is blames


def test_a_usual_factor_is_named_within_what_the_disc_is_unsure_of() -> None:
    """Twice the counts make an inertia four times smaller."""
    for u, off, code in (
        (0.0, 0.14, "speed_scale"),
        (0.0, 0.16, "gain"),
        (0.06, 0.17, "speed_scale"),
    ):
        fitted = parameter(0.0), parameter(1e-5 * math.exp(off) / 4.0)
        (found,) = scale_errors.by_disc(*fitted, 1e-5, u * 1e-5)
        assert found.code == code


def test_what_would_go_unseen_is_told_by_the_figures_but_the_inertia() -> None:
    """Twelve of chi-square: a speed by K alone, whose 8 % hide a factor of exp(.08 √12)."""
    known = {"K": (0.0, 0.08), "J": (0.0, 0.15), "R": (0.0, 0.08)}
    assert f"below a factor of {math.exp(0.08 * 12**0.5):.2g} would" in scale_errors._unseen(
        scale_errors.SPEED, known
    )
    both = {**known, "L": (0.0, 0.3)}
    weight = 1 / 0.08**2 + 1 / 0.3**2
    assert f"of {math.exp((12 / weight) ** 0.5):.2g} would" in scale_errors._unseen(
        scale_errors.AMPERES, both
    )
    assert scale_errors._unseen(scale_errors.SPEED, {"J": (0.0, 0.15)}).startswith("it would leave")


def test_a_bound_on_what_one_figure_costs() -> None:
    """A load adds inertia and is no fault; the voltage was read, and is never in doubt."""
    cost = scale_errors._cost
    assert cost("R", 0.2, 0.1, 9.0) == pytest.approx(4.0)
    assert cost("R", 0.4, 0.1, 9.0) == 9.0
    assert cost("J", 0.4, 0.1, 9.0) == 2.0
    assert cost("J", 0.1, 0.1, 9.0) == pytest.approx(1.0)
    assert cost("J", -0.4, 0.1, 9.0) == 9.0
    assert cost("V", 0.5, 0.1, 9.0) == pytest.approx(25.0)


def test_factors_worth_trying_are_usual_ones_each_figures_own_and_their_mean() -> None:
    known = {"R": (0.6, 0.1), "K": (0.2, 0.2), "J": (-0.8, 0.4)}
    found = list(scale_errors._factors(scale_errors.SPEED, known))
    usual = [x for x, is_usual in found if is_usual]
    assert usual == pytest.approx([math.log(f) for f in scale_errors.SPEED.usual])
    mean = (-0.2 / 0.04 + 1.6 / 0.16) / (1 / 0.04 + 4 / 0.16)
    assert [x for x, is_usual in found if not is_usual] == pytest.approx([-0.2, 0.4, mean])
    leads = list(scale_errors._factors(scale_errors.SERIES, known))
    assert leads == [(0.6, False), (pytest.approx(0.6), False)]
    assert list(scale_errors._factors(scale_errors.SERIES, {"R": (-0.6, 0.1)})) == []
    assert list(scale_errors._factors(scale_errors.SERIES, {"K": (0.6, 0.1)})) == []


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
