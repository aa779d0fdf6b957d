"""Several motors on one page: what differs, what only seems to, and what could not be fitted."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import Capture, Channel
from motorid.estimate.results.estimate import PARAMETERS
from motorid.workflow.many import Fitted
from motorid.workflow.motors import Motor, difference, motors, said, table
from motorid.workflow.motors_html import page
from tests.report.test_html import HOSTILE, parsed

UNITS = dict(zip(PARAMETERS, ("ohm", "H", "N*m/A", "N*m*s/rad", "kg*m**2", "N*m"), strict=True))


def fit(factor: float = 1.0, statistical: float = 0.001, instrument: float = 0.01) -> Fitted:
    total = float(np.hypot(statistical, instrument))
    values: dict[str, Any] = {
        name: {
            "value": factor, "statistical": factor * statistical,
            "instrument": factor * instrument, "total": factor * total,
            "status": "estimated", "unit": UNITS[name],
        }
        for name in PARAMETERS
    }  # fmt: skip
    return Fitted("run.h5", "0" * 64, "M1", values, (), "", 0.1)


def motor(label: str, made: Fitted, rig: str = "r", samples: int = 300) -> Motor:
    wave = np.sin(np.arange(samples) / 50.0)
    names = ("current", "terminal_voltage", "position")
    channels = {name: Channel(name, "A", wave) for name in names}
    return Motor(label, made, Capture(np.arange(samples), 1e3, channels), rig)


def test_what_one_rig_shares_cancels() -> None:
    """Half a per cent: real beside noise of .1 %, nothing beside instruments of 1 % of two rigs."""
    first, same, other = (
        motor("M", fit(f), rig) for f, rig in ((1, "r"), (1.005, "r"), (1.005, "q"))
    )
    near, far = (difference(one, first, "K") for one in (same, other))
    assert near is not None
    assert far is not None
    assert near.share == far.share == pytest.approx(0.005)
    assert near.u == pytest.approx(np.hypot(0.001, 0.001 * 1.005))
    assert near.real
    assert not far.real


def test_captures_that_name_no_rig_share_nothing() -> None:
    one, other = motor("A", fit(), ""), motor("B", fit(1.005), "")
    apart = difference(other, one, "K")
    assert apart is not None
    assert not apart.real


def test_only_real_differences_are_said() -> None:
    first, same, apart = motor("A", fit()), motor("B", fit(1.001)), motor("C", fit(0.95))
    lines = said([first, same, apart])
    assert len(lines) == len(PARAMETERS)
    assert lines[0].startswith("C: R is 5 % lower than in A (± ")
    assert said([first, same]) == ["no parameter differs from A beyond its uncertainty"]


def test_a_capture_that_could_not_be_fitted_is_named() -> None:
    failed = replace(motor("B", replace(fit(), values={}, failure="no motion")), capture=None)
    found = [motor("A", fit()), failed]
    assert "B: not fitted: no motion" in said(found)
    assert "no motion" in parsed(page(found)).text
    rows = list(csv.DictReader(io.StringIO(table(found))))
    assert [row["status"] for row in rows if row["motor"] == "B"] == ["no motion"] * len(PARAMETERS)


def test_the_page_has_every_motor_and_marks_what_differs() -> None:
    found = [motor("A", fit()), motor(HOSTILE, fit(1.2))]
    seen = parsed(page(found))
    assert "A" in seen.text
    assert "alert(1)" in seen.text
    assert [tag for tag, _ in seen.tags].count("script") == 1
    marked = [a for tag, a in seen.tags if tag == "td" and a.get("class") == "num real"]
    assert len(marked) == len(PARAMETERS)


@pytest.mark.slow
def test_fifty_motors_make_a_page_below_three_megabytes() -> None:
    found = [motor(f"M{k}", fit(1 + k / 100), samples=20_000) for k in range(50)]
    assert len(page(found).encode()) < 3_000_000


def test_names_are_told_apart(tmp_path: Any) -> None:
    paths = [tmp_path / "a.h5", tmp_path / "b.h5", tmp_path / "c.h5"]
    fits = [fit(), fit(), replace(fit(), serial="")]
    assert [one.label for one in motors(paths, fits)] == ["M1 (a)", "M1 (b)", "c"]
