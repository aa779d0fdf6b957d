"""Other people's measurements: one fixed configuration each, the one of docs/import.md."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorid.capture.model import Capture
from motorid.capture.table import NOTES, read_table
from motorid.estimate.partial import mechanical_fit
from motorid.estimate.results.estimate import Estimate, Parameter

ROBOTINO = "robotino/data_for_identification_with_integral.csv"


def robotino(folder: Path, wheel: int) -> Capture:
    return read_table(
        folder / ROBOTINO,
        ["time=t:ms", f"current=m{wheel}cur:A", f"speed=m{wheel}vel:rad/s"],
    )


def emps(folder: Path, name: str = "DATA_EMPS.mat") -> Capture:
    return read_table(folder / "emps" / name, ["time=t:s", "torque=vir*gtau:N", "position=qm:m"])


def codes(estimate: Estimate) -> set[str]:
    return {d.code for d in estimate.diagnostics}


def overlaps(parameter: Parameter, low: float, high: float) -> bool:
    assert parameter.interval_95 is not None
    return parameter.interval_95[0] <= high and low <= parameter.interval_95[1]


@pytest.mark.slow
def test_emps_agrees_with_its_published_values(shared_data: Path) -> None:
    estimate = mechanical_fit.fit([emps(shared_data)])
    for name, value, unit, within in (
        ("J", 95.11, "kg", 0.02), ("B", 203.5, "N·s/m", 0.03), ("T0", 20.39, "N", 0.03),
    ):  # fmt: skip
        parameter = estimate.parameters[name]
        assert parameter.value == pytest.approx(value, rel=within)
        assert overlaps(parameter, value, value)
        assert parameter.unit == unit
        assert parameter.status == "estimated"
    offset = estimate.nuisance["torque_offset"]
    assert overlaps(offset, -3.16, -3.16)
    assert "lack_of_fit" in codes(estimate)
    assert estimate.parameters["K"].status == "not_identifiable"


@pytest.mark.study
def test_emps_with_pulses_gives_the_same_axis(shared_data: Path) -> None:
    plain, pulsed = (
        mechanical_fit.fit([emps(shared_data, name)]).parameters
        for name in ("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat")
    )
    for name in ("J", "B", "T0"):
        gap = abs(plain[name].value - pulsed[name].value)
        assert gap < 2 * np.hypot(plain[name].total, pulsed[name].total)


@pytest.mark.slow
@pytest.mark.parametrize("wheel", [1, 2, 3])
def test_robotino_without_voltage_gives_ratios(shared_data: Path, wheel: int) -> None:
    estimate = mechanical_fit.fit([robotino(shared_data, wheel)])
    assert estimate.combinations["B/K"].status == "estimated"
    assert estimate.combinations["T0/K"].status == "estimated"
    assert {"unsigned_drive", "slow_sampling", "identifiability"} <= codes(estimate)
    for name in ("R", "L", "K", "B", "J", "T0"):
        assert estimate.parameters[name].status == "not_identifiable"


@pytest.mark.slow
@pytest.mark.parametrize("wheel", [1, 2, 3])
def test_robotino_with_its_torque_constant(shared_data: Path, wheel: int) -> None:
    """The authors give B 2.0 to 2.4e-5 N·m·s and T0 7 to 8e-3 N·m at the motor's shaft."""
    estimate = mechanical_fit.fit([robotino(shared_data, wheel)], fix={"K": 0.0514})
    assert overlaps(estimate.parameters["B"], 2.0e-5, 2.4e-5)
    assert overlaps(estimate.parameters["T0"], 7e-3, 8e-3)
    inertia = estimate.parameters["J"]
    if inertia.status == "estimated":
        assert overlaps(inertia, 7.1e-6, 7.1e-6)  # the rotor alone, by its data sheet
    else:
        assert "below" in inertia.note


@pytest.mark.slow
def test_robotino_wheel_one_holds_its_inertia(shared_data: Path) -> None:
    estimate = mechanical_fit.fit([robotino(shared_data, 1)], fix={"K": 0.0514})
    assert estimate.parameters["J"].status == "estimated"
    assert overlaps(estimate.combinations["J/K"], 7.1e-6 / 0.0514, 7.1e-6 / 0.0514)


def test_robotino_in_seconds_is_doubted(shared_data: Path) -> None:
    capture = read_table(
        shared_data / ROBOTINO, ["time=t:s", "current=m1cur:A", "speed=m1vel:rad/s"]
    )
    notes = " ".join(capture.provenance[NOTES])
    assert "t in ms, the map in s" in notes
    assert "too slow" in notes


@pytest.mark.slow
def test_pwm_runs_give_time_constant_and_gain(shared_data: Path) -> None:
    """Nine runs of one motor; two stay in the dead band. About 26.5 ms is published."""
    maps = ["time=Timestamp(ms):ms", "speed=Motor_Speed(RPM):rpm", "command=Commanded_PWM:1"]
    captures = [
        read_table(path, maps) for path in sorted((shared_data / "pwm-rpm").glob("log_*.csv"))
    ]
    estimate = mechanical_fit.fit(captures)
    assert "2 captures were left out" in " ".join(d.message for d in estimate.diagnostics)
    assert overlaps(estimate.combinations["JR/(K²+RB)"], 26.5e-3, 26.5e-3)
    slope = 2 * np.pi / 60 * (1411.9 - 712.3) / (5299 - 2899)  # between two steady speeds
    assert overlaps(estimate.combinations["K/(K²+RB)"], slope, slope)


@pytest.mark.slow
def test_position_loop_is_read_through_references(shared_data: Path) -> None:
    captures = [
        read_table(path, ["time=X.Data:s", "voltage=Y[3].Data:V", "position=Y[1].Data:deg"])
        for path in sorted((shared_data / "position-loop").glob("*.mat"))
    ]
    assert [len(capture) for capture in captures] == [6653, 7052, 8451]
    estimate = mechanical_fit.fit(captures)
    assert overlaps(estimate.combinations["JR/(K²+RB)"], 0.297, 0.310)
    assert overlaps(estimate.combinations["K/(K²+RB)"], 12.8, 13.1)


@pytest.mark.slow
def test_speed_bench_with_its_moving_average(shared_data: Path) -> None:
    captures = [
        read_table(
            path,
            ["time=Tempo:s", "current=Corrente:mA", "speed=Velocidade:rad/s"],
            aperture={"current": 0.128},
        )
        for path in sorted((shared_data / "speed-bench").glob("*.csv"))
    ]
    assert all(capture.period_s == pytest.approx(1e-3) for capture in captures)
    estimate = mechanical_fit.fit(captures)
    assert estimate.options["half_width_s"] >= 0.128
    assert estimate.combinations["T0/K"].status == "estimated"
    assert "lack_of_fit" in codes(estimate)


@pytest.mark.parametrize(
    ("motor", "R", "K"),
    [("cim", 0.0916, 0.0188), ("775pro", 0.0898, 0.00533), ("bag", 0.228, 0.00848)],
)
def test_static_points_give_resistance_and_torque_constant(
    shared_data: Path, motor: str, R: float, K: float
) -> None:
    capture = read_table(
        shared_data / "frc-curves" / f"{motor}.csv",
        [
            "voltage=Input Power/Current:V",
            "current=Current:A",
            "speed=Speed:rpm",
            "torque=Torque:N·m",
        ],
    )
    estimate = mechanical_fit.fit([capture])
    assert estimate.parameters["R"].value == pytest.approx(R, rel=2e-3)
    assert estimate.parameters["K"].value == pytest.approx(K, rel=2e-3)
    assert estimate.parameters["J"].status == "not_identifiable"
    assert "computed_table" in codes(estimate)
    assert ("constants_differ" in codes(estimate)) == (motor != "bag")
