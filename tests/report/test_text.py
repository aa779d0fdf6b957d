"""The table for a terminal, and how numbers are rounded and given units."""

from __future__ import annotations

import dataclasses

import pytest

from motorid.estimate.assembly.doubt import settled
from motorid.estimate.results.estimate import Diagnostic, Suspect
from motorid.report import html, text
from motorid.report.numbers import aligned, in_rpm, percent, scaled_unit, shown
from motorid.report.words import traceability
from tests.report.example import UNITS, estimate, parameter, partial


def width(rendered: str) -> int:
    return max(map(len, rendered.splitlines()))


def test_the_table_fits_a_terminal_and_names_the_six() -> None:
    rendered = text.render(estimate())
    assert width(rendered) <= 100
    lines = rendered.splitlines()
    assert [line.split()[0] for line in lines[2:8]] == ["R", "L", "K", "B", "J", "T0"]
    assert "2.603 ± 0.016 Ω" in lines[2]
    assert "3.904 ± 0.024 g·cm²" in lines[6]
    points = {line.index("±") for line in lines[2:8]}
    assert len(points) == 1


def test_what_is_unknown_fixed_or_at_its_bound_says_so() -> None:
    rendered = text.render(partial())
    assert "R, L: no voltage was measured" in rendered
    assert "not identifiable" in rendered
    assert "fixed" in rendered
    assert "< 23" in rendered
    assert "nan" not in rendered.lower()
    assert "None" not in rendered


def test_one_run_is_called_that_once() -> None:
    one = partial()
    assert text.render(one).count("This run only") == 1
    said = Diagnostic("one_run", "info", "This run only: the spread between runs is unknown.")
    told = dataclasses.replace(one, diagnostics=(said,))
    assert text.render(told).count("his run only") == 1
    assert "his run only" not in text.render(estimate())


def test_findings_come_worst_first() -> None:
    findings = tuple(Diagnostic(s, s, f"the {s} one") for s in ("info", "error", "warning"))
    rendered = text.render(estimate(diagnostics=findings))
    places = [rendered.index(f"The {s} one.") for s in ("error", "warning", "info")]
    assert places == sorted(places)


@pytest.mark.parametrize(
    ("unit", "value", "relative", "expected"),
    [
        ("ohm", 2.6034, 0.0034, "2.603 ± 0.017 Ω"),
        ("H", 1.8e-4, 0.02, "180.0 ± 7.1 µH"),
        ("ohm", 0.0916, 0.01, "91.6 ± 1.8 mΩ"),
        ("kg·m²", 0.51, 0.1, "0.51 ± 0.10 kg·m²"),
        ("A", 133.6, 0.2, "134 ± 52 A"),
        ("N·m", -2e-4, 0.01, "−200.0 ± 3.9 µN·m"),
        ("rad²", 3.1e-7, 0.1, "310 ± 61 ×10⁻⁹ rad²"),
        ("N", 8123.0, 0.3, "8100 ± 4800 N"),
        ("1", 0.737, 0.01, "0.737 ± 0.014"),
    ],
)
def test_numbers_carry_the_digits_that_the_uncertainty_supports(
    unit: str, value: float, relative: float, expected: str
) -> None:
    assert shown(parameter("x", unit, value, relative, 0.0)).text == expected


def test_uncertainties_that_round_up_keep_two_digits() -> None:
    p = dataclasses.replace(parameter("x", "A", 5.0), interval_95=(5.0 - 0.0996, 5.0 + 0.0996))
    assert shown(p).text == "5.00 ± 0.10 A"


def test_every_size_of_every_unit_is_shown_finite_and_short() -> None:
    for unit in UNITS.values():
        for power in range(-14, 8):
            seen = shown(parameter("x", unit, 3.0 * 10.0**power))
            assert len(seen.text) < 40
            assert (
                abs(float(seen.value.replace("−", "-")) / seen.factor / (3.0 * 10.0**power) - 1)
                < 0.01
            )


def test_helpers() -> None:
    assert aligned(["1.5", "12", "3.25"]) == [" 1.5 ", "12   ", " 3.25"]
    assert percent(0.001) == "0.10 %"
    assert percent(0.02) == "2.0 %"
    assert percent(None) == percent(float("nan")) == "—"
    assert scaled_unit("ohm", 0.0) == ("Ω", 1.0)
    assert in_rpm(parameter("n", "rad/s", 104.7198, 0.001, 0.0)) == "1000.0 rpm"
    assert in_rpm(parameter("i", "A", 1.0)) == ""


@pytest.mark.slow
def test_what_makes_a_value_doubtful_stands_above_the_table() -> None:
    lag = Suspect("current_lag", "current", "it is 4 ms late", "declare it", "named", {"R": 0.1})
    limit = Suspect("supply_limited", "supply", "it gives 2 A", "take a larger", "named")
    found = settled(estimate(suspects=(lag, limit)), [lag])
    rendered = text.render(found)
    head, table, rest = rendered.partition("value ± 95 %")
    assert table
    assert "4 ms late" in head
    assert "it gives 2 A" not in head.lower()
    assert "4 ms late" not in rest
    assert "it gives 2 a" in rest.lower()
    row = next(line for line in rest.splitlines() if line.strip().startswith("R "))
    assert row.endswith("doubtful")
    assert "R: doubtful: current lag could change it by" in rest
    page = html.render(found)
    assert page.index("4 ms late") < page.index("<table") < page.lower().index("it gives 2 a")
    assert page.count("4 ms late") == 1
    assert 'class="status doubtful"' in page


@pytest.mark.parametrize(
    ("cited", "said"),
    [
        ((False, False), "Traceability: none is established"),
        ((True, False), "Traceability of 1 of 2 captures: none is established"),
        ((True, True), "Traceability: the calibrated channels are traceable as far as"),
    ],
)
def test_it_states_what_the_scales_rest_on(cited: tuple[bool, ...], said: str) -> None:
    calibration = {"name": "bench.calibration.toml", "date": "2026-11-20", "sha256": "ab" * 32}
    inputs = [
        {**estimate().inputs[0], "calibration": calibration if given else None} for given in cited
    ]
    rendered = " ".join(text.render(estimate(inputs=inputs)).split())
    assert said in rendered
    assert "coverage factor k is 1.96" in rendered


def test_the_calibration_of_a_new_analysis_counts() -> None:
    new = {"calibration": {"name": "c.toml", "date": "2026-11-20", "sha256": "ab" * 32}}
    assert traceability(estimate(inputs=[{"reanalysed": new}])).startswith(
        "Traceability: the calibrated channels"
    )
    assert traceability(estimate(inputs=[])) == ""


@pytest.mark.parametrize("width", [20, 60, 80, 96, 400])
def test_no_line_is_wider_than_the_terminal(width: int) -> None:
    """A narrow table has no meanings; below 80 columns nothing is narrower."""
    rendered = text.render(estimate(), width)
    most = min(max(width, text.NARROWEST), text.WIDTH)
    words = [line for line in rendered.splitlines() if not line.startswith("  From ")]
    table = rendered[: rendered.index("derived")]
    assert max(map(len, words)) <= most
    assert ("torque constant" in table) is (width >= 96)
    for name in ("R", "L", "K", "B", "J", "T0"):
        assert f"\n  {name} " in table
