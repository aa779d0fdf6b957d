"""Gauge studies against published worked examples, to the digits printed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from motorid.errors import DataError, UsageError
from motorid.quality.anova import anova_table
from motorid.quality.gauge import Study, analyse
from motorid.quality.ranges import (
    a2,
    d2,
    d2_star,
    d3,
    degrees_of_freedom,
    degrees_of_moving_ranges,
    range_limits,
)
from motorid.quality.reference import golden, linearity, sigma_by_range
from tests.gauge.published import (
    AIAG_GRR,
    BIAS,
    BIAS_AT,
    ISO_A4,
    LINEARITY,
    LINEARITY_AT,
)


def study(values: np.ndarray) -> Study:
    parts, operators, _ = values.shape
    return Study(
        values,
        tuple(str(k + 1) for k in range(parts)),
        tuple("ABC"[:operators]),
    )


# Montgomery, appendix VI: n, d2, d3, A2, D3, D4.
CONSTANTS = [
    (2, 1.128, 0.853, 1.880, 0.0, 3.267),
    (3, 1.693, 0.888, 1.023, 0.0, 2.574),
    (5, 2.326, 0.864, 0.577, 0.0, 2.114),
    (7, 2.704, 0.833, 0.419, 0.076, 1.924),
    (10, 3.078, 0.797, 0.308, 0.223, 1.777),
    (25, 3.931, 0.708, 0.153, 0.459, 1.541),
]


@pytest.mark.parametrize("row", CONSTANTS)
def test_constants_of_range_charts(row: tuple[float, ...]) -> None:
    n = int(row[0])
    found = (d2(n), d3(n), a2(n), *range_limits(n))
    # a table's last digit may be off by one where it was computed from rounded ones
    assert found == pytest.approx(row[1:], abs=1.1e-3)


def test_factors_of_the_average_and_range_form() -> None:
    """K1, K2 and K3 as the AIAG's form prints them."""
    assert round(1 / d2(2), 4) == 0.8862
    assert round(1 / d2(3), 4) == 0.5908
    assert round(1 / d2_star(2, 1), 4) == 0.7071
    assert (round(1 / d2_star(3, 1), 4), round(1 / d2_star(10, 1), 4)) == (0.5231, 0.3146)


def test_aiag_anova_table() -> None:
    """AIAG MSA 4th edition, ANOVA table of the example (full model)."""
    rows = anova_table(AIAG_GRR)
    squares = [rows[n].squares for n in ("operator", "part", "operator × part", "repeatability")]
    assert [round(s, 4) for s in squares] == [3.1673, 88.3619, 0.3590, 2.7589]
    assert [row.degrees for row in rows.values()] == [9, 2, 18, 60, 89]
    assert rows["part"].f == pytest.approx(492.291, abs=5e-4)
    assert rows["operator"].f == pytest.approx(79.406, abs=5e-4)
    assert rows["operator × part"].f == pytest.approx(0.434, abs=5e-4)
    assert rows["operator × part"].p == pytest.approx(0.974, abs=5e-4)


def test_aiag_anova_components() -> None:
    """The same example: EV, AV, GRR, PV and their shares, the interaction pooled."""
    result = analyse(study(AIAG_GRR))
    assert result.pooled
    found = {name: c.sigma for name, c in result.components.items()}
    assert {name: round(s, 6) for name, s in found.items() if name != "TV"} == {
        "EV": 0.199933,
        "AV": 0.226838,
        "GRR": 0.302372,  # printed .302373, from components of six digits
        "PV": 1.042327,
    }
    assert round(found["TV"], 3) == 1.085
    study_share = {n: round(c.percent_study, 1) for n, c in result.components.items()}
    assert study_share == {"EV": 18.4, "AV": 20.9, "GRR": 27.9, "PV": 96.0, "TV": 100.0}
    shares = {n: round(c.percent_contribution, 2) for n, c in result.components.items()}
    assert shares == {"EV": 3.39, "AV": 4.37, "GRR": 7.76, "PV": 92.24, "TV": 100.0}
    assert result.categories == 4


def test_aiag_average_and_range() -> None:
    """The same data by average and range: the form's interim figures, then its results.

    The form multiplies by K1, K2, K3 of four digits and by averages of four decimals; what it
    prints therefore differs from the exact figures by up to 2 parts in 10,000.
    """
    data = study(AIAG_GRR)
    ranges = np.ptp(AIAG_GRR, axis=2).mean(axis=0)
    assert [round(r, 3) for r in ranges] == [0.184, 0.513, 0.328]
    assert round(float(ranges.mean()), 4) == 0.3417
    assert round(float(np.ptp(AIAG_GRR.mean(axis=(1, 2)))), 3) == 3.511
    result = analyse(data, method="range")
    found = {name: c.sigma for name, c in result.components.items()}
    printed = {"EV": 0.20188, "AV": 0.22963, "GRR": 0.30575, "PV": 1.10456, "TV": 1.14610}
    assert found == pytest.approx(printed, rel=3e-4)
    share = {n: c.percent_study for n, c in result.components.items()}
    assert share == pytest.approx(
        {"EV": 17.62, "AV": 20.04, "GRR": 26.68, "PV": 96.38, "TV": 100.0}, abs=0.01
    )
    assert result.categories == 5
    assert result.ranges_outside == (("4", "B"),)  # the chart of ranges: appraiser B, part 4


def test_iso_22514_7_annex_a() -> None:
    """ISO 22514-7:2012, Tables A.5 and A.6: pooled, as the interaction does not show."""
    rows = anova_table(ISO_A4)
    assert rows["operator × part"].f == pytest.approx(1.193, abs=5e-4)
    result = analyse(study(ISO_A4))
    assert result.pooled
    assert round(result.components["EV"].sigma, 4) == 0.1827
    assert result.components["AV"].sigma == pytest.approx(0.08683, abs=1e-5)
    assert result.components["PV"].sigma ** 2 == pytest.approx(6.501, abs=5e-4)
    full = analyse(study(ISO_A4), alpha=0.4)  # Table B.2: the full model
    assert not full.pooled
    assert full.components["INT"].sigma == pytest.approx(0.04528, abs=1e-5)
    assert full.components["AV"].sigma == pytest.approx(0.08591, abs=1e-5)


def test_tolerance_and_known_process() -> None:
    """%GRR of the tolerance is six sigma over it; a known process sigma stands for TV."""
    result = analyse(study(AIAG_GRR), tolerance=8.0, process_sigma=2.0)
    grr = result.grr
    assert grr.percent_tolerance == pytest.approx(100 * 6 * grr.sigma / 8)
    assert result.components["TV"].sigma == 2.0
    assert grr.percent_study == pytest.approx(50 * grr.sigma)
    with pytest.raises(UsageError, match="tolerance"):
        analyse(study(AIAG_GRR), tolerance=0.0)


def test_aiag_linearity() -> None:
    """AIAG MSA 4th edition, the linearity example; the same line in ISO 22514-7, 7.1.3."""
    result = linearity(LINEARITY_AT, list(LINEARITY))
    assert (round(result.intercept.value, 4), round(result.slope.value, 4)) == (0.7367, -0.1317)
    assert round(100 * result.r_squared, 1) == 71.4
    assert result.sigma == pytest.approx(0.23954, abs=5e-6)
    assert (round(result.slope.t, 3), round(result.intercept.t, 3)) == (-12.043, 10.158)
    assert not result.acceptable
    means = [bias for _, bias in result.biases]
    assert means == pytest.approx([0.491667, 0.125, 0.025, -0.29167, -0.61667], abs=5e-6)


def test_aiag_bias() -> None:
    """AIAG MSA, independent sample method: no bias; 3rd edition's sigma from the range."""
    result = golden(BIAS, BIAS_AT)
    assert round(result.mean, 4) == 6.0067
    assert not result.biased
    assert result.interval_95 == pytest.approx((-0.1107, 0.1241), abs=5e-4)
    assert sigma_by_range(BIAS) == pytest.approx(0.22514, abs=5e-5)


def test_cg_and_cgk_by_their_definition() -> None:
    """20 % of the tolerance over six sigma; Cgk loses what the bias takes."""
    values = np.array([9.9, 10.1, 10.0, 10.2, 9.8] * 10)
    result = golden(values, 9.95, tolerance=6.0)
    assert result.cg == pytest.approx(0.2 * 6 / (6 * values.std(ddof=1)))
    assert result.cgk == pytest.approx((0.1 * 6 - 0.05) / (3 * values.std(ddof=1)))
    other = golden(values, 9.95, tolerance=6.0, share=0.15, spread=4.0)
    assert other.cg == pytest.approx(0.15 * 6 / (4 * values.std(ddof=1)))
    uncertain = golden(values, 9.95, reference_uncertainty=0.05)
    assert golden(values, 9.95).biased
    assert not uncertain.biased


def test_intervals_hold_the_figures_they_belong_to() -> None:
    for name in ("EV", "GRR"):
        found = analyse(study(AIAG_GRR)).components[name]
        low, high = found.interval_95 or (math.nan, math.nan)
        assert 0.4 * found.sigma < low < found.sigma < high


def test_moving_ranges_that_share_readings_tell_less_than_separate_ones() -> None:
    assert degrees_of_moving_ranges(2) == degrees_of_freedom(2, 1)  # one range shares nothing
    for count in (3, 10, 100):
        assert degrees_of_moving_ranges(count) < degrees_of_freedom(2, count - 1)
    assert degrees_of_moving_ranges(100) == pytest.approx(0.6 * 99, rel=0.05)


@pytest.mark.slow
def test_intervals_cover_the_truth() -> None:
    """Of 400 simulated studies the 95 % intervals of EV and GRR hold the truth nearly so often."""
    rng = np.random.default_rng(7)
    held = {"EV": 0, "GRR": 0}
    for _ in range(400):
        part, who = rng.normal(0, 2, (10, 1, 1)), rng.normal(0, 0.5, (1, 3, 1))
        result = analyse(study(part + who + rng.normal(0, 0.4, (10, 3, 3))))
        for name, truth in (("EV", 0.4), ("GRR", math.hypot(0.4, 0.5))):
            low, high = result.components[name].interval_95 or (math.nan, math.nan)
            held[name] += low <= truth <= high
    assert held["EV"] == pytest.approx(380, abs=18)  # four standard deviations of a binomial
    assert held["GRR"] == pytest.approx(380, abs=18)


def test_one_operator_and_refusals() -> None:
    one = analyse(study(AIAG_GRR[:, :1]))
    assert set(one.components) == {"EV", "GRR", "PV", "TV"}
    assert one.components["EV"].sigma == one.grr.sigma
    # of one operator the parts' variance is that of their means, less that of a mean of repeats
    means, within = AIAG_GRR[:, 0].mean(axis=1), AIAG_GRR[:, 0].var(axis=1, ddof=1).mean()
    parts = means.var(ddof=1) - within / AIAG_GRR.shape[2]
    assert one.components["EV"].sigma == pytest.approx(math.sqrt(within), rel=1e-9)
    assert one.components["PV"].sigma == pytest.approx(math.sqrt(parts), rel=1e-9)
    with pytest.raises(DataError, match="2 repeats"):
        study(AIAG_GRR[:, :, :1])
    broken = AIAG_GRR.copy()
    broken[3, 1, 2] = np.nan
    with pytest.raises(DataError, match="missing"):
        study(broken)


def test_a_gauge_that_cannot_see_its_own_spread() -> None:
    """Equal readings in every cell: no number of categories, rather than a million."""
    flat = np.repeat(np.arange(4.0)[:, None, None], 6, axis=1).reshape(4, 2, 3)
    result = analyse(study(flat))
    assert result.grr.sigma == 0
    assert result.categories is None
