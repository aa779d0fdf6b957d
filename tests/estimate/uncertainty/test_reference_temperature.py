"""R at 25 °C: against closed forms, and against the simulated winding's own temperature."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motorid
from bench.coverage.runs import Thermometer
from motorid.acquire.record import capture_over
from motorid.capture import store
from motorid.capture.facts import of_provenance
from motorid.capture.model import CURRENT, VOLTAGE, Capture, Channel, Stated
from motorid.capture.table import read_table
from motorid.errors import DataError
from motorid.estimate.effects import winding_temperature
from motorid.estimate.effects.reference.temperature import AMBIENT_TEMPERATURE, SELF_HEATING
from motorid.estimate.effects.winding_temperature import BOUND, Coefficients, self_heating
from motorid.estimate.results.estimate import Estimate, Parameter, Rise
from motorid.estimate.results.status import Status
from motorid.estimate.uncertainty import reference_temperature
from motorid.estimate.uncertainty.reference_temperature import ambient_of, at_25, warmth_of
from motorid.rig import Rig
from motorid.rig_file import parse
from motorid.sim.options import parse_url
from motorid.sim.port import SimPort
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit

HOT = "sim://?motor=faulhaber-2338s006s&load_inertia=2e-5&ambient=31&speed=max&seed=4"
RIG = """name = "warm"
port = "sim://"
[wiring]
counts_per_turn = 2048
[limits]
current_a = 3.4
speed_rad_s = 1500
supply_min_v = 3
supply_max_v = 15
[nameplate]
voltage_v = 6
[conditions]
ambient_c = 31
ambient_uncertainty_c = 0.5
[sampling]
rate_hz = 4000
[program]
levels_v = [[6], [6]]
drive_s = 1.0
coast_s = 0.5
"""
THERMAL = "[thermal]\nwinding_k_w = 6.0\nwinding_s = 8.0\nmagnet_per_k = -0.0011\n"


def resistance(value: float = 2.0, share: float = 0.01) -> dict[str, Parameter]:
    u = share * value
    reach = math.exp(1.96 * share)
    return {
        "R": Parameter(
            "R", "ohm", value, u, 0.0, u, (value / reach, value * reach), Status.ESTIMATED
        )
    }


def test_at_25_is_the_copper_law_with_its_uncertainties() -> None:
    inputs = [{"ambient_c": 40.0, "ambient_uncertainty_c": 2.0}]
    warmth = warmth_of(inputs, Rise(5.0, 1.0, 3.0, ""))
    cold, shares = at_25(resistance(), warmth, Coefficients())
    factor = 1 + 0.00393 * 20
    assert cold["R_25"].value == pytest.approx(2.0 / factor)
    for cause, relative in (
        ("ambient temperature", 0.00393 * 2.0 / factor),
        ("self-heating", 0.00393 * 1.0 / factor),
        ("copper coefficient", 20 * 5e-5 / factor),
    ):
        assert shares["R_25"][cause] == pytest.approx(relative * 2.0 / factor)
    total = math.hypot(0.01, *(u / cold["R_25"].value for u in shares["R_25"].values()))
    assert cold["R_25"].total == pytest.approx(total * cold["R_25"].value)
    assert cold["R_25"].interval_95[1] == pytest.approx(
        cold["R_25"].value * math.exp(1.95996 * total), rel=1e-5
    )
    assert "K_25" not in cold


def test_a_side_that_a_finding_widened_is_wide_at_25_degrees_too() -> None:
    hot = resistance()
    R = hot["R"]
    assert R.value is not None
    assert R.interval_95 is not None
    hot["R"] = replace(R, interval_95=(0.8 * R.value, R.interval_95[1]))
    room = warmth_of([{"ambient_c": 25.0, "ambient_uncertainty_c": 0.0}], Rise(0.0, 0.0, 0.0, ""))
    low, high = at_25(hot, room, Coefficients())[0]["R_25"].interval_95 or (0.0, 0.0)
    assert low == pytest.approx(0.8 * R.value)
    assert high == pytest.approx(R.interval_95[1])


def test_an_unknown_ambient_adds_its_own_width() -> None:
    width = warmth_of([{"ambient_c": None}], Rise(0.0, 0.0, 0.0, "")).ambient_uncertainty
    assert width == pytest.approx(25.0 / math.sqrt(12.0))
    _, shares = at_25(resistance(), warmth_of([{}], Rise(0.0, 0.0, 0.0, "")), Coefficients())
    assert shares["R_25"]["ambient temperature"] / 2.0 == pytest.approx(0.00393 * width, rel=0.02)


def driven(amperes: float, seconds: float, period_s: float = 1e-3) -> Capture:
    n = round(seconds / period_s) + 1
    channels = {
        CURRENT: Channel(CURRENT, "A", np.full(n, amperes)),
        VOLTAGE: Channel(VOLTAGE, "V", np.full(n, 6.0), sense="terminals"),
    }
    return Capture(np.arange(n) * round(1e9 * period_s), 1e9, channels)


def test_self_heating_by_thermal_figures_is_the_exponential() -> None:
    R, i, tau, k_w, T = 2.0, 1.5, 8.0, 6.0, 10.0
    rise = self_heating([driven(i, T)], R, {"winding_k_w": k_w, "winding_s": tau})
    assert rise is not None
    assert rise.heat_j == pytest.approx(R * i**2 * T)
    mean = R * i**2 * k_w * (1 - tau / T * (1 - math.exp(-T / tau)))
    assert rise.kelvin == pytest.approx(mean, rel=1e-3)
    assert rise.uncertainty_k == pytest.approx(0.2 * mean, rel=1e-3)


def test_self_heating_without_figures_is_bounded_by_the_power_at_stall() -> None:
    """Stalled at its highest voltage no winding warms by more than 150 K/s: half of that in 10 ms,
    and the second of two runs begins where the first one ended."""
    one = driven(3.0, 0.01, 1e-5)
    rise = self_heating([one], 2.0, {})
    assert rise is not None
    assert rise.kelvin + math.sqrt(3.0) * rise.uncertainty_k == pytest.approx(0.75, rel=0.01)
    two = self_heating([one, one], 2.0, {})
    assert two is not None
    assert two.kelvin == pytest.approx(2 * rise.kelvin, rel=0.01)


def test_no_current_or_no_time_gives_no_r_25() -> None:
    silent = replace(driven(1.0, 0.1), channels={VOLTAGE: driven(1.0, 0.1).channels[VOLTAGE]})
    assert self_heating([silent], 2.0, {}) is None


@pytest.fixture(scope="module")
def exact() -> Estimate:
    capture = noisy(clean_capture(FAULHABER), 0, 2e-3, 1e-4, 5e-3)
    return fit([replace(capture, ambient_c=45.0, ambient_uncertainty_c=1.0)])


@pytest.mark.slow
def test_the_estimate_has_r_25_its_causes_and_its_words(exact: Estimate) -> None:
    cold, hot = exact.at_25["R_25"], exact.parameters["R"]
    assert cold.value == pytest.approx(hot.value / (1 + 0.00393 * (20 + exact.rise.kelvin)))
    shares = exact.budget["R_25"]
    assert set(shares) >= {"noise", "ambient temperature", "self-heating", "copper coefficient"}
    assert math.hypot(*shares.values()) == pytest.approx(cold.total, rel=1e-6)
    assert "ambient 45 °C ± 2 K" in cold.note
    assert "K_25" not in exact.at_25


def test_what_a_wrong_room_would_do_is_said(exact: Estimate) -> None:
    """By the copper law: a winding that was 10 K warmer has less at 25 °C."""
    said = next(s for s in exact.suspects if s.code == "ambient_temperature")
    ambient, _, given = ambient_of(exact.inputs)
    assert exact.rise is not None
    above = ambient + exact.rise.kelvin - 25.0
    share = (1.0 + Coefficients().copper_per_k * above) / (
        1.0 + Coefficients().copper_per_k * (above + 10.0)
    ) - 1.0
    assert said.strength == "not excluded"
    assert f"R_25 by {100.0 * share:+.2g} %" in said.evidence
    assert ("for want of" in said.evidence) is not given


def run(text: str, folder: Path, name: str) -> tuple[Capture, float]:
    """A capture of the warm rig, and the winding's mean temperature by the current squared."""
    rig: Rig = parse(text, name)
    port = SimPort(name, parse_url(HOT))
    bench: Any = port._device.board
    watch = Thermometer(bench.bench)
    path = folder / f"{name}.h5"
    capture_over(port, rig, rig.program, path)
    return store.load(path), watch.means()[0]


@pytest.mark.slow
@pytest.mark.long
def test_the_simulated_winding_is_as_warm_as_said(tmp_path: Path) -> None:
    from motorid.sim import truth

    known, winding_temperature = run(RIG + THERMAL, tmp_path, "figures")
    plain, _ = run(RIG, tmp_path, "plain")
    assert winding_temperature > 33.0  # the run heats it
    by_figures, by_bound = fit([known], model="heating"), fit([plain], model="six")
    assert by_figures.rise is not None
    assert by_figures.rise.kelvin == pytest.approx(winding_temperature - 31.0, rel=0.2)
    assert by_bound.rise is not None
    assert (
        abs(by_bound.rise.kelvin - (winding_temperature - 31.0))
        < math.sqrt(3) * by_bound.rise.uncertainty_k
    )
    for estimate in (by_figures, by_bound):
        low, high = estimate.at_25["R_25"].interval_95
        assert low < truth(HOT)["R_25"] < high
        assert estimate.parameters["R"].value > 1.02 * truth(HOT)["R_25"]
    assert "K_25" in by_figures.at_25
    assert "K_25" not in by_bound.at_25
    better = by_figures.alternative  # free of what heating does to the six
    assert better is not None
    for name in ("R_25", "K_25"):
        low, high = better.at_25[name].interval_95
        assert low < truth(HOT)[name] < high
    by_runs = fit([plain], model="heating")  # and as the run itself shows it
    assert by_runs.rise is not None
    assert abs(by_runs.rise.kelvin - (winding_temperature - 31.0)) < 2 * by_runs.rise.uncertainty_k
    assert by_runs.rise.uncertainty_k < 0.25 * by_runs.rise.kelvin
    total = [e.at_25["R_25"].total for e in (by_figures, by_bound)]
    assert total[0] < total[1]
    assert "thermal figures" in by_bound.at_25["R_25"].note


@pytest.mark.slow
def test_the_command_line_gives_the_ambient(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from motorid.cli.main import run as motorid_command

    path = tmp_path / "a.h5"
    store.save(noisy(clean_capture(FAULHABER), 0, 2e-3, 1e-4, 5e-3), path)
    values = []
    for more in ([], ["--ambient", "65", "--ambient-uncertainty", "1"]):
        assert motorid_command(["fit", str(path), "--model", "six", "--json", *more]) == 0
        values.append(json.loads(capsys.readouterr().out)["at_25"]["R_25"])
    factor = (1 + 0.00393 * 40) / (1 + 0.00393 * -2.5)
    assert values[0]["value"] / values[1]["value"] == pytest.approx(factor, rel=1e-3)
    assert values[0]["uncertainty"]["total"] > 4 * values[1]["uncertainty"]["total"]
    assert "not given" in values[0]["note"]
    assert motorid_command(["fit", str(path), "--ambient-uncertainty", "1"]) == 2
    by_call = motorid.fit(path, ambient=(65.0, 1.0)).at_25["R_25"].value
    assert by_call == pytest.approx(values[1]["value"], rel=1e-6)


def test_a_thermometers_column_is_the_ambient(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = "\n".join(f"{k},{k % 3},{21 + 2 * (k % 2)}" for k in range(20))
    path.write_text("t,i,room\n" + rows, encoding="utf-8")
    maps = ["time=t:ms", "current=i:mA", "ambient=room:°C"]
    capture = read_table(path, maps, offset_uncertainty={"ambient": 0.5})
    assert capture.ambient_c == pytest.approx(22.0)
    assert capture.ambient_uncertainty_c == pytest.approx(math.hypot(0.5, 1.0))
    assert "ambient" not in capture.channels
    told = read_table(path, maps, ambient_c=19.0, ambient_uncertainty_c=0.2)
    assert (told.ambient_c, told.ambient_uncertainty_c) == (19.0, 0.2)


def test_a_rig_for_a_second_look_brings_its_own_thermal_figures() -> None:
    own, other = of_provenance({"rig": RIG + THERMAL}), Stated(thermal={"winding_s": 9.0})
    stated = winding_temperature.figures(replace(driven(1.0, 0.1), stated=own.under(other)))
    assert (stated["winding_k_w"], stated["winding_s"], stated["voltage_v"]) == (6.0, 9.0, 6.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("not = toml =", "is no TOML"),
        ("[thermal]\nwinding_s = 'long'\n", "no number for thermal.winding_s"),
        ("[nameplate]\nvoltage_v = inf\n", "no number for nameplate.voltage_v"),
        ("thermal = 3\n", "no number for thermal"),
    ],
)
def test_what_a_rigs_text_does_not_tell_is_said(text: str, said: str) -> None:
    stated = of_provenance({"rig": text})
    assert said in stated.unread
    assert (stated.nameplate, stated.thermal) == ({}, {})
    estimate = fit([replace(clean_capture(FAULHABER, Plan(count=500)), stated=stated)])
    (found,) = [d for d in estimate.diagnostics if d.code == "rig_unread"]
    assert said in found.message


def test_no_figure_of_a_motor_is_infinite() -> None:
    with pytest.raises(DataError, match="winding_s of the motor is inf"):
        Stated(thermal={"winding_s": math.inf})


def test_the_largest_of_its_own_causes_says_how_to_narrow_it() -> None:
    shares = {AMBIENT_TEMPERATURE.name: 0.01, SELF_HEATING.name: 0.02}
    said = reference_temperature._joined("so", shares)
    assert said == f"so; to narrow it, {SELF_HEATING.remedy}"
    nothing = dict.fromkeys(shares, 0.0)
    assert reference_temperature._joined("so", nothing) == "so"


@pytest.mark.parametrize(
    ("inputs", "ambient"),
    [
        ([{"ambient_c": 20.0, "ambient_uncertainty_c": 0.5}, {"ambient_c": 24.0}],
         (22.0, 0.5, True)),
        ([{"ambient_c": 20.0}, {}], (22.5, 25.0 / 12**0.5, False)),
        ([], (22.5, 25.0 / 12**0.5, False)),
    ],
)  # fmt: skip
def test_the_ambient_is_that_of_all_runs_or_of_any_room(
    inputs: list[dict[str, float]], ambient: tuple[float, float, bool]
) -> None:
    assert reference_temperature.ambient_of(inputs) == pytest.approx(ambient)


def test_what_the_temperature_rests_on_is_said() -> None:
    given = [{"ambient_c": 21.0, "ambient_uncertainty_c": 0.5}]
    rise = Rise(4.0, 1.0, 30.0, "by the motor's thermal figures")
    assert reference_temperature.words(given, rise) == (
        "ambient 21 °C ± 0.98 K; self-heating 4 ± 2 K, by the motor's thermal figures, from 30 J"
    )
    exact = reference_temperature.words([{"ambient_c": 21.0}], Rise(4.0, 1.0, 30.0, BOUND))
    assert exact.startswith(f"ambient 21 °C, as exact; self-heating none to 8 K, {BOUND}")
    assert "not given, so anything from 10 to 35 °C" in reference_temperature.words([{}], rise)


def test_a_winding_is_above_the_reference_by_ambient_and_rise_and_magnets_by_ambient() -> None:
    rise = Rise(4.0, 1.0, 30.0, "")
    found = warmth_of([{"ambient_c": 21.0, "ambient_uncertainty_c": 0.5}], rise)
    assert (found.winding, found.magnets) == (0.0, -4.0)
    assert (found.ambient_uncertainty, found.rise_uncertainty) == (0.5, 1.0)
