"""Detection power: the statistics on a stub whose truth is known, and the command on real runs."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from motorid.cli.main import run
from motorid.errors import UsageError
from motorid.quality.detection import LEVELS, Range, Trials, most_named
from motorid.quality.product import Product
from motorid.report import power as report
from motorid.rig import Rig
from motorid.sim.options import parse_url
from motorid.workflow import power

RANGE = Range(0.002, 0.5)


def test_levels_are_the_same_on_every_machine() -> None:
    found = [RANGE.severity(k) for k in range(LEVELS)]
    assert (found[0], found[-1]) == (0.002, 0.5)
    assert found == sorted(set(found))
    assert [RANGE.level(x) for x in found] == list(range(LEVELS))
    assert RANGE.level(1e-9) == 0
    assert RANGE.level(9.0) == LEVELS - 1


def chance(middle: float, width: float, alarms: float) -> Callable[[float], float]:
    return lambda x: alarms + (1 - alarms) * float(norm.cdf((math.log(x) - middle) / width))


def played(rng: np.random.Generator, found: Callable[[float], float], rejected: int) -> Trials:
    """Forty trials as the study plays them, of a defect with a known chance to be found."""
    levels = RANGE.first()
    trials = Trials(RANGE, (), (), 60, rejected)
    while len(trials.found) < 40:
        new = [RANGE.severity(k) for k in levels][: 40 - len(trials.found)]
        hits = tuple(bool(rng.random() < found(x)) for x in new)
        trials = replace(
            trials, severities=(*trials.severities, *new), found=(*trials.found, *hits)
        )
        levels = trials.next()
    return trials


@pytest.mark.slow
def test_the_intervals_hold_the_truth() -> None:
    rng = np.random.default_rng(1)
    held, count = {0.5: 0, 0.95: 0}, 30
    for _ in range(count):
        middle, width = math.log(rng.uniform(0.01, 0.15)), rng.uniform(0.05, 0.5)
        alarms = 0.02
        trials = played(rng, chance(middle, width, alarms), int(rng.binomial(60, alarms)))
        for share in held:
            truth = math.exp(middle + width * norm.ppf((share - alarms) / (1 - alarms)))
            one = trials.severity(share)
            held[share] += one.low <= truth <= (one.high or math.inf)
    assert min(held.values()) >= 24  # 28.5 of 30, less four standard deviations


@pytest.mark.slow
def test_the_share_of_good_motors_that_fail_is_taken_off() -> None:
    """Twenty trials a level, as many found as the curve says, and three good motors of ten fail."""
    middle, width, alarms = math.log(0.03), 0.4, 0.3
    found = chance(middle, width, alarms)
    severities, hits = [], []
    for level in range(0, LEVELS, 2):
        x = RANGE.severity(level)
        severities += [x] * 20
        hits += [k < round(20 * found(x)) for k in range(20)]
    trials = Trials(RANGE, tuple(severities), tuple(hits), 6000, 1800)
    for share in (0.5, 0.95):
        truth = math.exp(middle + width * norm.ppf((share - alarms) / (1 - alarms)))
        assert trials.severity(share).value == pytest.approx(truth, rel=0.08)
    assert len(trials.next()) == len(hits) // 2  # a long study looks seldom
    assert len(replace(trials, severities=(0.1,), found=(True,)).next()) == 8


@pytest.mark.slow
def test_what_is_never_found_is_said_to_lie_beyond() -> None:
    trials = played(np.random.default_rng(2), lambda x: 0.0, 0)
    assert trials.severity(0.5).value is None
    assert trials.severity(0.95).high is None
    assert trials.severity(0.5).low > 0.2


@pytest.mark.slow
def test_a_step_is_found_between_its_neighbours() -> None:
    """No largest likelihood exists where all below pass and all above fail."""
    trials = played(np.random.default_rng(3), lambda x: float(x > 0.05), 0)
    half = trials.severity(0.5)
    assert half.value == pytest.approx(0.05, rel=0.15)
    assert half.low < 0.05 < (half.high or 0.0)


def test_good_motors_that_fail_count_as_false_rejects() -> None:
    """The same findings mean less where half of the good motors fail as well."""
    hits = [True, False] * 4
    severities = tuple(RANGE.severity(k) for k in RANGE.first())
    few, many = (Trials(RANGE, severities, tuple(hits), 60, bad) for bad in (0, 30))
    assert (few.severity(0.95).low) < (many.severity(0.95).low)


def test_the_most_named_come_first() -> None:
    assert most_named([["K"], ["R", "K"], ["J"], ["R", "K", "K"]]) == ["K", "R"]


def stub(*of: Any) -> dict[str, Any]:
    """A weak magnet of 5 % or more is found; a brush drop makes the run INVALID beyond 1 V."""
    _, _, _, _, defect, severity, number = of
    if defect == "weak-magnet" and severity >= 0.05:
        return {"outcome": "FAIL", "named": ["K_25"]}
    if defect == "brush-drop" and severity >= 1.0:
        return {"outcome": "INVALID", "named": ["model_fits"]}
    bad = defect == power.GOOD and number == 3
    return {"outcome": "FAIL" if bad else "PASS", "named": ["R_25"] if bad else []}


@pytest.mark.slow
def test_a_study_and_its_table(
    monkeypatch: pytest.MonkeyPatch, product: Product, line_rig: Rig, tmp_path: Path
) -> None:
    monkeypatch.setattr(power, "inspect", stub)
    shown: list[tuple[int, int]] = []
    found = power.study(
        product, line_rig, tmp_path, defects=("weak-magnet", "brush-drop"), motors=24, good=20,
        progress=lambda done, total: shown.append((done, total)),
    )  # fmt: skip
    magnet, brushes = found.powers
    assert (found.good, found.rejected, found.named) == (20, 1, ("R_25",))
    half = magnet.trials.severity(0.5)
    assert half.low < 0.05 < (half.high or 0.0)
    assert magnet.named == ("K_25",)
    assert (magnet.invalid, len(magnet.trials.found)) == (0, 24)
    assert brushes.invalid == sum(brushes.trials.found) > 0
    assert shown[-1] == (20 + 2 * 24, 20 + 2 * 24)
    assert [done for done, _ in shown] == sorted(done for done, _ in shown)
    said = report.text(found)
    assert "1 of 20 did not pass, 5.0 %" in said
    assert "INVALID" in said
    assert "most good motors" not in said
    assert "most good motors do not pass" in report.text(replace(found, rejected=15))
    every = replace(magnet.trials, found=(True,) * 24, rejected=20)
    blind = report.text(replace(found, powers=(replace(magnet, trials=every),)))
    assert "below 0.2" in blind
    again = power.study(
        product, line_rig, tmp_path, defects=("weak-magnet", "brush-drop"), motors=24, good=20
    )
    assert report.to_dict(again) == report.to_dict(found)


def test_a_study_goes_on_where_it_was_stopped(
    monkeypatch: pytest.MonkeyPatch, product: Product, line_rig: Rig, tmp_path: Path
) -> None:
    """And gives what one that was never stopped gives."""
    calls: list[int] = []

    def counted(*of: Any) -> dict[str, Any]:
        if len(calls) == 25:
            raise KeyboardInterrupt
        calls.append(1)
        return stub(*of)

    monkeypatch.setattr(power, "inspect", counted)
    options: dict[str, Any] = {"defects": ("weak-magnet",), "motors": 16, "good": 20}
    with pytest.raises(KeyboardInterrupt):
        power.study(product, line_rig, tmp_path / "cut", **options)
    calls.append(1)
    found = power.study(product, line_rig, tmp_path / "cut", **options)
    assert len(calls) == 20 + 16 + 1
    monkeypatch.setattr(power, "inspect", stub)
    whole = power.study(product, line_rig, tmp_path / "whole", **options)
    assert report.to_dict(found) == report.to_dict(whole)


@pytest.mark.parametrize("name", power.DEFECTS)
@pytest.mark.parametrize("motor", ["faulhaber-2338s006s", "maxon-re35"])
def test_every_severity_is_a_motor_that_the_simulator_takes(
    name: str, motor: str, line_rig: Rig
) -> None:
    rig = replace(line_rig, port=f"sim://?motor={motor}")
    limits = power.DEFECTS[name].range(parse_url(rig.port))
    good = parse_url(power.specimen(rig, power.SPREAD, power.GOOD, 0.0, 7))
    for level in (0, LEVELS - 1):
        bad = parse_url(power.specimen(rig, power.SPREAD, name, limits.severity(level), 7))
        option = power.DEFECTS[name].option
        assert getattr(bad, option) != getattr(good, option)
        assert replace(bad, **{option: getattr(good, option)}) == good  # the same motor besides


def test_a_defect_is_put_on_a_motor_with_its_own_spread(product: Product, line_rig: Rig) -> None:
    good, bad, other = (
        parse_url(power.specimen(line_rig, power.SPREAD, name, 0.1, number))
        for name, number in ((power.GOOD, 1), ("weak-magnet", 1), (power.GOOD, 2))
    )
    assert good.magnet != 1.0
    assert bad.magnet == pytest.approx(0.9 * good.magnet)
    assert other.magnet != good.magnet
    assert other.seed != good.seed == bad.seed
    tasks = [
        power._task(product, line_rig, "D000001", spread, name, severity, number).digest
        for spread, name, severity, number in (
            (power.SPREAD, "cogging", 0.1, 1), (power.SPREAD, "cogging", 0.2, 1),
            (power.SPREAD, "cogging", 0.1, 2), (power.SPREAD, "windage", 0.1, 1),
            ({**power.SPREAD, "copper": 0.0}, "cogging", 0.1, 1),
        )
    ]  # fmt: skip
    assert len(set(tasks)) == len(tasks)


def test_what_cannot_be_studied_is_refused(product: Product, line_rig: Rig, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="real one"):
        power.study(product, replace(line_rig, port="/dev/ttyUSB0"), tmp_path)
    with pytest.raises(UsageError, match="no defect 'brush'"):
        power.study(product, line_rig, tmp_path, defects=("brush",))
    with pytest.raises(UsageError, match="no spread"):
        power.study(product, line_rig, tmp_path, spread={"brass": 0.1})
    assert product.serial is not None
    nameless = replace(product, serial=replace(product.serial, example=""))
    with pytest.raises(UsageError, match=r"serial\.example"):
        power.study(nameless, line_rig, tmp_path)


@pytest.mark.slow
def test_a_motor_goes_through_the_line(product: Product, line_rig: Rig) -> None:
    """A magnet that lost half fails by K; one that lost 0.2 % passes as a good motor does."""
    assert product.serial is not None
    of = product, line_rig, product.serial.example, power.SPREAD
    assert power.inspect(*of, power.GOOD, 0.0, 1) == {"outcome": "PASS", "named": []}
    assert power.inspect(*of, "weak-magnet", 0.002, 1)["outcome"] == "PASS"
    weak = power.inspect(*of, "weak-magnet", 0.15, 1)
    assert weak["outcome"] == "FAIL"
    assert "K_25" in weak["named"]


def test_the_command(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(power, "inspect", stub)
    call = "power --product sim-disc --rig sim-line --defect weak-magnet --motors 8 --good 8"
    words = [*call.split(), "--jobs", "1", "-o", str(tmp_path / "out")]
    assert run(words) == 0
    assert "weaker magnet" in capsys.readouterr().out
    found = json.loads((tmp_path / "out" / "power.json").read_text(encoding="utf-8"))
    (magnet,) = found["defects"]
    assert [one["found"] for one in magnet["trials"]] == [False] * 5 + [True] * 3
    assert magnet["by"] == ["K_25"]
    assert found["false_rejects"]["not_passed"] == 1
    assert run(words) == 2  # power.json exists
    assert run([*words, "--force"]) == 0
