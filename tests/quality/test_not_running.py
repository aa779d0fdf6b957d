"""A motor that does not run fails where the rig is sound; a rig that does not work is INVALID."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from motorid.errors import UsageError
from motorid.quality.product import Product, SelfTest, parse
from motorid.quality.verdict import Outcome
from motorid.workflow.check import Inspection, Line
from motorid.workflow.not_running import DEFECTS, _past
from motorid.workflow.shift_folder import newest_first

Inspect = Callable[[str, str], Inspection]


@pytest.fixture
def inspect(product: Product, line_rig: Any, tmp_path: Path) -> Inspect:
    """Measures a motor with options of the simulated rig on one line."""

    def run(serial: str, options: str = "", by: Product = product) -> Inspection:
        port = f"{line_rig.port}&{options}" if options else line_rig.port
        with Line(replace(line_rig, port=port), by, tmp_path) as line:
            return line.inspect(serial)

    return run


DEAD = [
    ("copper=0.1", "shorted"),
    ("fault=stall", "seized"),
    ("fault=encoder_reversed", "reversed leads"),
]
RIG = ["encoder_dead", "supply", "current_dead"]


@pytest.mark.slow
def test_a_dead_motor_fails_on_a_rig_that_was_shown_to_be_sound(
    inspect: Any, product: Product
) -> None:
    patient = replace(product, self_test=SelfTest(dead_in_a_row=9))
    before = inspect("D000001", "fault=stall", patient).verdict
    assert before.outcome is Outcome.INVALID
    assert "no motor has passed" in before.reasons[0]
    assert inspect("D000002", "", patient).verdict.outcome is Outcome.PASS
    for options, defect in DEAD:
        done = inspect("D000003", options, patient)
        assert done.verdict.outcome is Outcome.FAIL
        assert done.exit_code == 1
        assert defect in done.verdict.reasons[0]
    for fault in RIG:
        done = inspect("D000004", f"fault={fault}", patient)
        assert done.verdict.outcome is Outcome.INVALID
        assert done.exit_code == 3
    assert not [r for r in done.verdict.reasons if re.search(r"raise|higher|increase", r)]


@pytest.mark.slow
def test_an_open_winding_fails_after_a_second_contact(inspect: Inspect) -> None:
    options = "copper=10&lead_resistance=100&sense=bridge"
    assert inspect("D000002", "").verdict.outcome is Outcome.PASS
    first = inspect("D000003", options).verdict
    assert first.outcome is Outcome.INVALID
    assert "motor or contact" in first.reasons[0]
    again = inspect("D000003", options).verdict
    assert again.outcome is Outcome.FAIL
    assert "open winding" in again.reasons[0]


@pytest.mark.slow
def test_dead_motors_in_a_row_put_the_rig_in_doubt(inspect: Inspect, product: Product) -> None:
    inspect("D000001", "")
    outcomes = [inspect(f"D00001{k}", "fault=stall").verdict.outcome for k in range(3)]
    assert outcomes == [Outcome.FAIL, Outcome.FAIL, Outcome.INVALID]
    last = inspect("D000019", "fault=stall").verdict
    assert "2 motors in a row" in last.reasons[0]


@pytest.mark.slow
def test_only_the_golden_motor_counts_where_one_is_named(
    product: Product, tmp_path: Path, inspect: Any
) -> None:
    golden = replace(product, self_test=SelfTest(("D000007",)))
    inspect("D000001", "", golden)
    done = inspect("D000002", "fault=stall", golden).verdict
    assert done.outcome is Outcome.INVALID
    assert "D000007" in done.reasons[0]
    damaged = next(tmp_path.glob("D000001_*")) / "verdict.json"
    damaged.write_text("{}")
    assert [one.serial for one in _past(newest_first(tmp_path), golden)] == ["D000002"]


def test_the_products_table(product: Product) -> None:
    text = product.text + '\n[self_test]\ngolden = ["D000007"]\ninspections = 20\n'
    assert parse(text).self_test == SelfTest(("D000007",), 20, 2)
    with pytest.raises(UsageError, match=r"self_test\.golden must be a list"):
        parse(product.text + '\n[self_test]\ngolden = "D000007"\n')


def test_every_sign_has_a_defect() -> None:
    from motorid.acquire.signs import Sign

    assert set(DEFECTS) == set(Sign)
