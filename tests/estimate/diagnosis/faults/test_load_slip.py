"""A load that slips: what is seen of it, and within which sizes it is looked for."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis.faults import load_slip as module
from motorid.estimate.fit.block_regression import Start


def test_what_follows_changes_by_so_much_a_step_and_no_more() -> None:
    speed = np.array([2.0, 5.0, 5.0, 5.0, -9.0, -9.0])
    assert module.followed(speed, 2.0).tolist() == [2.0, 4.0, 5.0, 5.0, 3.0, 1.0]
    assert module.followed(speed, 99.0).tolist() == speed.tolist()


@pytest.mark.parametrize("known", [True, False])
def test_nothing_is_seen_without_blocks_or_a_start(
    known: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    begin = Start((0.3, 50.0), {"R": 2.0})
    monkeypatch.setattr(module, "blocks", lambda _: "blocks" if known else None)
    monkeypatch.setattr(module, "start", lambda b: begin if b == "blocks" else None)
    monkeypatch.setattr(module, "_hypothesis", lambda records, at: (records, at))
    records: Any = ["record"]
    assert module.seen(records) == (((records, begin), begin) if known else None)


def test_a_share_and_an_acceleration_are_looked_for_about_the_start(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "measured_speed", lambda *_: None)
    one: Any = object()
    found = module._hypothesis([one], Start((0.3, 50.0), {}))
    assert (found.code, found.sizes) == ("load_slips", ((0.3, 50.0),))
    assert found.scale == pytest.approx((0.1, 5.0))
    assert found.lower == pytest.approx((0.02, 5.0))
    assert found.upper == pytest.approx((0.99, 500.0))
    said = found.words(np.array([0.25, 123.4]))
    assert said.where == "load"
    assert said.evidence.startswith("25 % of the inertia follows the shaft at 123 rad/s²")
    assert found.belongs is not None
    assert found.belongs(np.array([0.25, 123.4])) == {"J": 0.25}


def slipping(share: float, explained: float = 1.0) -> Any:
    """Blocks of K i = J dw/dt - J2 d(w - w2)/dt + B w + T0, of which ``share`` is J2's of J."""
    rng = np.random.default_rng(6)
    period_s, count = 0.01, 120
    speed = 100.0 * (1.0 - np.exp(-np.arange(count) * period_s / 0.08))
    pull = np.gradient(speed) / period_s
    b = SimpleNamespace(
        speed=speed, acceleration=pull, runs=(slice(0, count),), period_s=np.array([period_s]),
        driven=np.ones(count, dtype=bool),
    )  # fmt: skip
    rate = float(module.RATES[8] * np.abs(pull).max())
    behind = module._behind(b, rate)  # type: ignore[arg-type]
    law = np.column_stack([pull, speed, np.ones(count)])
    current = law @ [2e-3, 1e-4, 0.1] - share * 2e-3 * behind
    noise = rng.standard_normal(count)
    b.current = current + (1.0 - explained) * noise * np.abs(current).max()
    return b, rate, law


@pytest.mark.parametrize(("share", "shown"), [(0.3, True), (0.02, False), (0.9, True)])
def test_the_currents_tell_its_share_and_its_acceleration(
    share: float, shown: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    b, rate, law = slipping(share)
    monkeypatch.setattr(module, "friction_columns", lambda _: law)
    monkeypatch.setattr(module, "electrical", lambda *_: (2.0, 0.05))
    found = module.start(b)
    assert (found is not None) is shown
    if found is not None:
        assert found.size == pytest.approx((share, rate), rel=1e-6)
        assert found.motor == pytest.approx(
            {"R": 2.0, "K": 0.05, "J": 0.05 * 2e-3, "B": 0.05 * 1e-4, "T0": 0.05 * 0.1}
        )


def test_a_load_that_explains_little_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    b, _, law = slipping(0.3, explained=0.5)
    monkeypatch.setattr(module, "friction_columns", lambda _: law)
    monkeypatch.setattr(module, "electrical", lambda *_: (2.0, 0.05))
    assert module.start(b) is None
    sure, _, law = slipping(0.3)
    monkeypatch.setattr(module, "electrical", lambda *_: None)
    assert module.start(sure) is None
