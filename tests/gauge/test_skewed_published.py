"""Capability of skewed readings: published tables, exact distributions, and how often it holds."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import minimize_scalar

from motorid.cli.main import run
from motorid.errors import DataError, UsageError
from motorid.quality.capability import capability
from motorid.quality.pearson_curve import PearsonCurve, curve_of
from motorid.quality.skewed import TAIL, box_cox, by_box_cox, by_percentiles

# Gruska, Mirkhani and Lamberson (1989), which Clements' form uses: the distance of the 0.135 %
# percentile from the mean, in standard deviations, for skewness 0 and kurtosis -1.4, -1.2 ... 3.8
SYMMETRIC = (
    1.512, 1.727, 1.966, 2.210, 2.442, 2.653, 2.839, 3.000, 3.140, 3.261, 3.366, 3.458, 3.539,
    3.611, 3.674, 3.731, 3.782, 3.828, 3.870, 3.908, 3.943, 3.975, 4.004, 4.031, 4.056, 4.079,
    4.101,
)  # fmt: skip
# Harter (1969), as Bulletin 17B prints it: frequency factors of Pearson's type III of skewness 1
SKEWNESS_1 = {0.01: -1.58838, 0.1: -1.12762, 0.5: -0.16397, 0.9: 1.34039, 0.99: 3.02256}
# Montgomery, Statistical Quality Control, times between failures of a valve (hours), and their
# power 0.2777, which makes them nearly normal
FAILURES = (
    286, 948, 536, 124, 816, 729, 4, 143, 431, 8, 2837, 596, 81, 227, 603, 492, 1199, 1214, 2831,
    96,
)  # fmt: skip
FAILURES_POWER = (
    4.80986, 6.70903, 5.72650, 3.81367, 6.43541, 6.23705, 1.46958, 3.96768, 5.39007, 1.78151,
    9.09619, 5.89774, 3.38833, 4.51095, 5.91690, 5.59189, 7.16124, 7.18601, 9.09083, 3.55203,
)  # fmt: skip
MEMBERS = {
    "type I": stats.beta(2, 5),
    "type I, no mode": stats.beta(0.5, 0.7),
    "uniform": stats.uniform(),
    "normal": stats.norm(),
    "type III": stats.gamma(3),
    "type IV, symmetric": stats.t(9),
    "type V": stats.invgamma(9),
    "type VI": stats.betaprime(5, 9),
    "exponential": stats.expon(),
}


def curve(mean: float, variance: float, skewness: float, kurtosis: float) -> PearsonCurve:
    return PearsonCurve(*(np.array([x]) for x in (mean, math.sqrt(variance), skewness, kurtosis)))


def test_the_table_of_standardized_tails() -> None:
    for step, printed in enumerate(SYMMETRIC):
        found = curve(0.0, 1.0, 0.0, -1.4 + 0.2 * step)
        # the table is cut or rounded in its last digit
        assert -found.quantile(TAIL)[0] == pytest.approx(printed, abs=1.1e-3), step
        assert found.quantile(1.0 - TAIL)[0] == pytest.approx(printed, abs=1.1e-3), step


def test_the_table_of_type_three() -> None:
    found = curve(0.0, 1.0, 1.0, 1.5)
    for probability, printed in SKEWNESS_1.items():
        assert round(found.quantile(probability)[0], 5) == printed


@pytest.mark.parametrize("member", MEMBERS.values(), ids=list(MEMBERS))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_members_of_the_family_are_met(member: stats.rv_continuous, sign: float) -> None:
    mean, variance, skewness, kurtosis = (float(m) for m in member.stats("mvsk"))
    found = curve(sign * mean, variance, sign * skewness, kurtosis)
    for p in (TAIL, 0.3, 0.5, 0.99, 1.0 - TAIL):
        expected = sign * float(member.ppf(p if sign > 0 else 1.0 - p))
        assert found.quantile(p)[0] == pytest.approx(expected, abs=1e-4 * math.sqrt(variance))
        assert found.cdf(expected) == pytest.approx(p, abs=1e-5)


def test_a_skewness_and_kurtosis_between_the_types_break_nothing() -> None:
    """Also at the borders of the types, and for moments that no distribution has."""
    skew, kurtosis = (
        a.ravel() for a in np.meshgrid(np.linspace(-3, 3, 13), np.linspace(-2, 30, 33))
    )
    many = PearsonCurve(np.zeros_like(skew), np.ones_like(skew), skew, kurtosis)
    low, middle, high = (many.quantile(p) for p in (TAIL, 0.5, 1.0 - TAIL))
    assert np.all(low <= middle)
    assert np.all(middle <= high)
    assert np.all(high - low < 40.0)


@pytest.mark.slow
def test_percentile_indices_of_a_normal_curve_are_the_usual_ones() -> None:
    """ISO 22514-2: for a normal process both definitions agree."""
    rng = np.random.default_rng(3)
    values = rng.normal(10.0, 1.0, 50_000)
    found = by_percentiles(values, 6.0, 13.0, 0.95)
    assert found.pp is not None
    assert found.pp[0] == pytest.approx(7.0 / 6.0, abs=0.03)
    assert found.ppk[0] == pytest.approx(1.0, abs=0.03)
    assert found.outside == pytest.approx(stats.norm.sf(3.0) + stats.norm.sf(4.0), rel=0.2)


@pytest.mark.slow
def test_percentile_indices_by_the_definition() -> None:
    """Of the very curve that the moments of the readings give, by hand."""
    values = np.random.default_rng(4).gamma(3.0, 2.0, 300)
    found = by_percentiles(values, 0.1, 30.0, 0.95)
    low, middle, high = (float(curve_of(values).quantile(p)[0]) for p in (TAIL, 0.5, 1.0 - TAIL))
    assert found.percentiles == pytest.approx((low, middle, high))
    assert found.pp is not None
    assert found.pp[0] == pytest.approx(29.9 / (high - low))
    sides = (30.0 - middle) / (high - middle), (middle - 0.1) / (middle - low)
    assert found.ppk[0] == pytest.approx(min(sides))
    above = by_percentiles(values, None, 30.0, 0.95)
    below = by_percentiles(values, 0.1, None, 0.95)
    assert (above.ppk[0], below.ppk[0]) == pytest.approx(sides)
    assert above.pp is below.pp is None
    assert above.outside + below.outside == pytest.approx(found.outside)
    # the moments make it too large, and the interval makes up for that
    assert above.ppk[1] < math.sqrt(above.ppk[1] * above.ppk[2]) < above.ppk[0] < above.ppk[2]
    shape = stats.skew(values, bias=False), stats.kurtosis(values, bias=False)
    drawn = curve_of(values)
    assert (drawn.skewness[0], drawn.kurtosis[0]) == pytest.approx(shape)


def test_the_power_of_the_times_between_failures() -> None:
    """Montgomery's table to its digits; the mean of the transformed times is 5.38662."""
    shown = 1.0 + 0.2777 * box_cox(np.array(FAILURES, float), 0.2777)
    assert [round(x, 5) for x in shown] == pytest.approx(FAILURES_POWER, abs=1.1e-5)
    assert round(float(shown.mean()), 5) == 5.38662
    # a known power is taken as it is: by hand from the printed figures
    times = np.array(FAILURES * 2, float)
    found = capability(times, None, 30_000.0, shape="box-cox", power=0.2777)
    printed = np.array(FAILURES_POWER * 2)
    by_hand = (30_000.0**0.2777 - printed.mean()) / (3.0 * printed.std(ddof=1))
    assert found.ppk.value == pytest.approx(by_hand, rel=1e-5)
    assert found.power == 0.2777


def test_a_known_power_has_the_narrower_interval() -> None:
    values = skewed(100)
    searched = capability(values, None, 0.04, shape="box-cox")
    known = capability(values, None, 0.04, shape="box-cox", power=0.0)
    assert searched.ppk.interval is not None
    assert known.ppk.interval is not None
    widths = [one.ppk.interval[1] - one.ppk.interval[0] for one in (searched, known)]
    assert widths[1] < 0.8 * widths[0]
    normal = capability(np.log(values), None, math.log(0.04), shape="normal")
    assert known.ppk.value == pytest.approx(normal.ppk.value)
    assert known.ppk.interval == pytest.approx(normal.ppk.interval, abs=0.06)  # Bissell's
    with pytest.raises(UsageError, match="power"):
        capability(values, None, 0.04, power=0.5)
    with pytest.raises(UsageError, match="power"):
        capability(values, None, 0.04, shape="box-cox", power=7.0)


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e6])
def test_box_cox_against_scipy(unit: float) -> None:
    """λ by SciPy's own search, the index from SciPy's transform, whatever the unit."""
    values = np.random.default_rng(5).weibull(1.6, 120)
    limit = float(values.max()) * 1.4
    found = by_box_cox(values * unit, None, limit * unit, 0.95)
    assert found is not None
    shown, power = stats.boxcox(values)
    assert found.power == pytest.approx(power, abs=2e-4)
    moved = float(stats.boxcox(np.array([limit]), power)[0])
    assert found.ppk[0] == pytest.approx((moved - shown.mean()) / (3 * shown.std(ddof=1)), rel=1e-3)
    assert found.ppk[1] < found.ppk[0] < found.ppk[2]
    assert found.outside == pytest.approx(stats.norm.sf(3.0 * found.ppk[0]), rel=1e-9)
    assert found.percentiles[1] == pytest.approx(float(np.median(values)) * unit, rel=0.1)


@pytest.mark.slow
def test_the_interval_of_box_cox_is_that_of_a_plain_bootstrap() -> None:
    """Each resample drawn one by one, its λ where SciPy finds its likelihood largest.

    Written out: ``stats.boxcox_llf`` takes milliseconds a call, and says the same of the first.
    """

    def unlikely(power: float, x: np.ndarray) -> float:
        spread = float(np.var((x**power - 1.0) / power if power else np.log(x)))
        return len(x) / 2 * math.log(spread) - (power - 1.0) * float(np.log(x).sum())

    values, limit = skewed(100), 0.04
    found = by_box_cox(values, None, limit, 0.95)
    assert found is not None
    rng, drawn = np.random.default_rng(11), []
    for _ in range(300):
        one = rng.choice(values, len(values))
        power = float(minimize_scalar(unlikely, (-2.0, 2.0), args=(one,)).x)
        if not drawn:
            assert power == pytest.approx(stats.boxcox_normmax(one, method="mle"), abs=1e-4)
        shown = box_cox(one, power)
        moved = float(box_cox(np.array([limit]), power)[0])
        drawn.append((moved - shown.mean()) / (3 * shown.std(ddof=1)))
    low, high = np.quantile(drawn, [0.025, 0.975])
    assert found.ppk[1:] == pytest.approx((low, high), abs=0.15 * (high - low))


@pytest.mark.slow
def test_the_interval_of_box_cox_holds() -> None:
    """A lognormal process, 60 readings: nominally 95 of 100."""
    rng = np.random.default_rng(6)
    member = stats.lognorm(0.4)
    limit = float(member.ppf(stats.norm.cdf(3.6)))
    held = 0
    for _ in range(80):
        found = by_box_cox(member.rvs(60, random_state=rng), None, limit, 0.95)
        assert found is not None
        held += found.ppk[1] <= 1.2 <= found.ppk[2]
    assert held >= 66  # 0.95 of 80, less four standard deviations and what a bootstrap lacks


def skewed(count: int, seed: int = 8) -> np.ndarray:
    return np.random.default_rng(seed).lognormal(-5.0, 0.5, count)


def test_the_shape_is_chosen_by_the_stated_rule() -> None:
    rng = np.random.default_rng(9)
    plain = capability(rng.normal(5.0, 1.0, 100), 1.0, 9.0)
    assert (plain.shape, plain.cp.value is not None) == ("normal", True)
    power = capability(skewed(100), None, 0.04)
    assert power.shape == "box-cox"
    assert (power.cpk.value, power.pp.value) == (None, None)
    assert power.power == pytest.approx(0.0, abs=0.4)
    assert power.fit_p >= 0.05 > power.normal_p
    below = capability(-skewed(100), -0.04, None)  # no power of what is negative
    assert below.shape == "percentile"
    assert below.ppk.value is not None
    for values, limit in ((skewed(20) ** 3, 0.1), (-skewed(40), -1e-4)):
        few = capability(values, None, limit)
        assert few.shape == "normal"
        assert "too few" in few.why


def test_normal_theory_would_have_flattered_or_blamed() -> None:
    """At 1.33 of the normal formula a lognormal process has far more outside than 32 ppm."""
    values = skewed(400)
    limit = float(values.mean() + 4.0 * values.std(ddof=1))
    wrong = capability(values, None, limit, shape="normal")
    right = capability(values, None, limit)
    assert wrong.ppk.value == pytest.approx(4.0 / 3.0)
    assert right.ppk.value is not None
    assert right.ppk.value < 1.0
    assert right.ppm_expected > 20 * wrong.ppm_expected


def test_what_no_shape_fits_is_said() -> None:
    rng = np.random.default_rng(10)
    two = np.concatenate([rng.normal(1.0, 0.02, 100), rng.normal(2.0, 0.02, 100)])
    found = capability(two, 0.5, 2.5)
    assert found.shape == "percentile"  # a power does not make two humps one
    assert found.fit_p < 0.05


@pytest.mark.parametrize(
    "values",
    [
        np.array([1.0, 2.0] * 50),
        np.array([1.0] * 99 + [2.0]),
        np.append(np.linspace(0.99, 1.01, 99), 1e9),
    ],
    ids=["two values", "one other", "one far out"],
)
def test_readings_without_a_shape_still_have_indices(values: np.ndarray) -> None:
    """As before there were shapes: a chart must not be lost for want of one."""
    found = capability(values, 0.5, 3.0)
    assert found.ppk.value is not None
    assert found.fit_p < 0.05  # which is said


def test_a_shape_that_cannot_be_is_refused() -> None:
    with pytest.raises(UsageError, match="positive"):
        capability(-skewed(100), -0.04, None, shape="box-cox")
    with pytest.raises(UsageError, match="positive"):
        capability(skewed(100), -0.04, 1.0, shape="box-cox")
    with pytest.raises(DataError, match="50 readings"):
        capability(skewed(49), None, 0.04, shape="percentile")


@pytest.mark.slow
def test_many_readings_are_resampled_as_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    """The interval of 5,500 readings is that of each of them, though there are 2,750 bins."""
    values = skewed(5_500)
    found = by_box_cox(values, None, 0.04, 0.95)
    monkeypatch.setattr("motorid.quality.skewed.MOST_BINS", 6000)
    each = by_box_cox(values, None, 0.04, 0.95)
    assert found is not None
    assert each is not None
    width = each.ppk[2] - each.ppk[1]
    assert found.ppk[1:] == pytest.approx(each.ppk[1:], abs=0.1 * width)


def test_the_command_says_which_shape_and_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "readings.csv"
    path.write_text("ripple\n" + "\n".join(f"{v:.8f}" for v in skewed(100)), encoding="utf-8")
    call = ["trend", str(path), "--quantity", "ripple", "--upper", "0.04", "--rules", "limits"]
    assert run(call) in (0, 1)
    said = capsys.readouterr().out
    assert "shape: Box-Cox" in said
    assert "of a normal shape" in said
    assert run([*call, "--shape", "percentile", "--json"]) in (0, 1)
    able = json.loads(capsys.readouterr().out)["capability"]
    assert able["shape"] == "percentile"
    assert len(able["percentiles"]) == 3
    assert run([*call, "--shape", "normal"]) in (0, 1)
    said = capsys.readouterr().out
    assert "mislead" in said
