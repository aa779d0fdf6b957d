"""Product files: every key known, typed and within reason, or one clear sentence."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.errors import UsageError
from motorid.quality.product import SerialRule, load_product, parse, presets

SMALL = """
[motor]
voltage_v = 6
segments = 5
[[program.steps]]
kind = "drive_volts"
volts = 4.0
duration_s = 0.1
[limits.R_25]
low = 2.4
high = 2.8
"""


def test_the_packaged_products_are_products() -> None:
    assert "sim-disc" in presets()
    for name in presets():
        assert load_product(name).limits


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("[limits.R_25]", "[limits.R25]", "no such quantity, did you mean 'R_25'"),
        ("low = 2.4", "lwo = 2.4", "unknown key limits.R_25.lwo; the nearest is limits.R_25.low"),
        (
            "[limits",
            '[decision]\nmodel = "wide"\n[limits',
            "decision.model must be one of six, better",
        ),
        ("low = 2.4", "low = 3.4", "needs a low below its high"),
        ("low = 2.4", 'unit = "mohm"', "must be ohm"),
        ("low = 2.4", 'rule = "global_risk"', "process_mean and process_sd"),
        ("low = 2.4", 'rule = "hunch"', "must be one of simple"),
        ("low = 2.4", "low = nan", "must be a number"),
        ("volts = 4.0", "", "steps[0].volts is missing"),
        ("voltage_v = 6", "", "motor.voltage_v is missing"),
        ("segments = 5", "[limits.ripple_turn]\nhigh = 1", "needs motor.segments"),
        ("[motor]", '[serial]\npattern = "(a+)+"\n[motor]', "no groups"),
        ("[motor]", '[serial]\npattern = "A{2}"\nexample = "B"\n[motor]', "does not match"),
        ("[motor]", "[motor", "not valid TOML"),
    ],
)
def test_errors_say_where_and_what(old: str, new: str, says: str) -> None:
    assert parse(SMALL).limits["R_25"].high == 2.8
    with pytest.raises(UsageError) as caught:
        parse(SMALL.replace(old, new), "my.toml")
    assert str(caught.value).startswith("my.toml: ")
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("key", "least", "most"),
    [
        ("r", 0, 10),
        ("coverage_factor", 0.1, 10),
        ("consumer_risk", 1e-9, 0.5),
        ("process_mean", -1e12, 1e12),
        ("process_sd", 1e-15, 1e12),
    ],
)
def test_figures_of_a_rule_stay_within_reason(key: str, least: float, most: float) -> None:
    def given_(value: float) -> object:
        return parse(SMALL + f"{key} = {value!r}\n", "x.toml")

    for value in (least, most):
        assert given_(value)
    for value in (least - max(abs(least), 1e-15), 1.2 * most):
        with pytest.raises(UsageError, match=f"R_25.{key} must be a number from"):
            given_(value)


def test_a_limit_may_have_a_rule_of_its_own() -> None:
    text = SMALL.replace("low = 2.4", 'low = 2.4\nrule = "specific_risk"\nconsumer_risk = 0.01')
    rule = parse(text).limits["R_25"].rule
    assert (rule.name, rule.consumer_risk) == ("specific_risk", 0.01)


def test_absent_files() -> None:
    with pytest.raises(UsageError, match="did you mean 'sim-disc'"):
        load_product("sim-disk")
    with pytest.raises(UsageError, match="no product file"):
        load_product(Path("nowhere/x.toml"))


def test_the_slowest_pattern_allowed_is_quick() -> None:
    rule = SerialRule(r"\d{0,63}\d{0,63}\d{0,63}X")
    parse(SMALL.replace("[motor]", f"[serial]\npattern = '{rule.pattern}'\n[motor]"))
    start = time.process_time()
    assert rule.problem("1" * 64)
    assert time.process_time() - start < 0.5


@pytest.mark.slow
@given(st.text(max_size=300))
def test_any_text_is_a_product_or_a_sentence(text: str) -> None:
    with contextlib.suppress(UsageError):
        assert parse(text).limits


@pytest.mark.slow
@given(st.text(max_size=100))
def test_any_serial_gets_an_answer(serial: str) -> None:
    problem = SerialRule("D[0-9]{6}", "D000123").problem(serial)
    assert bool(problem) != (len(serial) == 7 and serial[0] == "D" and serial[1:].isascii()
                             and serial[1:].isdigit())  # fmt: skip
