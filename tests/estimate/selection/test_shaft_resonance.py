"""Where two masses are looked for, and what a shaft would leave; against least squares."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.selection import shaft_resonance
from motorid.estimate.solver.problem import Linearised, Unknown

RNG = np.random.default_rng(9)
N = 80
VALUES = {"R": 2.0, "J": 2e-6}
TWO = TERMS["two-masses"]


def line(residual: np.ndarray | None = None) -> Linearised:
    shared, own = RNG.standard_normal((N, 2)), RNG.standard_normal((N, 1))
    precision = np.array([2.0])
    inverse = 1.0 / (float(own[:, 0] @ own[:, 0]) + 2.0)
    orthogonal = shared - own @ (inverse * own.T @ shared)
    left = RNG.standard_normal(N) if residual is None else residual
    return Linearised(left, shared, own, orthogonal, precision, (), (slice(0, N),), np.array([0.5]))


def solved(*lines: Linearised) -> Any:
    information = sum(one.orthogonal.T @ one.shared for one in lines)
    unknowns = (Unknown("R", 2.0, log=True), Unknown("J", 2e-6, log=True))
    return SimpleNamespace(
        records=lines, information=information, unknowns=unknowns, own=[np.zeros(1)] * len(lines),
        values=np.array([2.0, 2e-6]), slopes=np.array([2.0, 2e-6]),
    )  # fmt: skip


def test_what_a_shaft_leaves_is_what_no_move_of_the_others_explains() -> None:
    lines = [line(), line()]
    moved = [RNG.standard_normal(N) for _ in lines]
    records: Any = [SimpleNamespace(residuals=lambda *_, r=r: [0.5 * r]) for r in moved]
    start = {"J2_share": 0.3, "Ks": 1.0, "b": 0.1}
    left, step = shaft_resonance._left(records, solved(*lines), start)
    rows, targets = [], []
    for k, one in enumerate(lines):
        table = np.zeros((N + 1, 4))
        table[:N, :2], table[:N, 2 + k] = one.shared, one.own[:, 0]
        table[N, 2 + k] = np.sqrt(2.0)
        rows.append(table)
        targets.append(np.append(moved[k], 0.0))
    found = np.linalg.lstsq(np.concatenate(rows), np.concatenate(targets), rcond=None)[0]
    rest = np.concatenate(targets) - np.concatenate(rows) @ found
    assert left == pytest.approx(float(rest @ rest))
    assert step == pytest.approx(found[:2])


def test_a_spring_too_stiff_to_be_followed_leaves_all() -> None:
    record: Any = SimpleNamespace(residuals=lambda *_: [np.full(N, np.inf)])
    left, step = shaft_resonance._left(
        [record], solved(line()), {"J2_share": 0.3, "Ks": 1.0, "b": 1}
    )
    assert left == np.inf
    assert not step.any()


class Looked:
    """Springs of records whose resonances, and what each shaft leaves, are given."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, resonances: list[float], best: tuple[float, float],
        gain: float = 500.0, coloured: bool = True, asked: bool = False,
    ) -> None:  # fmt: skip
        self.tried, self.best, self.gain = list[tuple[float, float]](), best, gain
        monkeypatch.setattr(shaft_resonance, "_is_coloured", lambda _: coloured)
        monkeypatch.setattr(shaft_resonance, "_bare", lambda *_: [])
        monkeypatch.setattr(shaft_resonance, "_resonances", lambda *_: resonances)
        monkeypatch.setattr(shaft_resonance, "_left", self.left)
        one = line(np.full(N, np.sqrt(1000.0 / N)))
        self.found = shaft_resonance.springs([], solved(one), VALUES, (), asked)

    def left(self, _b: Any, _s: Any, shaft: Any) -> tuple[float, np.ndarray]:
        share = shaft["J2_share"]
        resonance = float(np.sqrt(shaft["Ks"] / (VALUES["J"] * share * (1 - share))))
        self.tried.append((round(share, 6), round(resonance, 3)))
        off = 10.0 * abs(share - self.best[0]) + abs(resonance / self.best[1] - 1.0)
        return 1000.0 - self.gain + 100.0 * off, np.array([0.01, -0.02])


def test_shares_and_peaks_are_tried_and_then_about_the_best_peak(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked = Looked(monkeypatch, [200.0, 300.0], (0.6, 302.9))
    first, about = looked.tried[:6], looked.tried[6:]
    assert set(first) == {(s, r) for s in shaft_resonance.SHARES for r in (200.0, 300.0)}
    assert about == [(0.6, pytest.approx(300.0 * a, abs=1e-3)) for a in shaft_resonance.ABOUT]
    (one,) = looked.found
    assert one.term is TWO
    assert one.start["J2_share"] == 0.6
    assert one.start["Ks"] == pytest.approx(2e-6 * 0.6 * 0.4 * 303.0**2)
    assert one.start["b"] == pytest.approx(2 * 0.02 * one.start["Ks"] / 303.0)
    assert one.gain == pytest.approx(500.0 - 100.0 * abs(303.0 / 302.9 - 1.0))
    assert one.shift == pytest.approx({"R": 0.02, "J": -4e-8})


def test_a_shaft_must_promise_something_unless_it_is_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    exact = (0.6, 300.0)
    assert len(Looked(monkeypatch, [300.0], exact, gain=31.0).found) == 1
    assert Looked(monkeypatch, [300.0], exact, gain=29.0).found == []
    assert len(Looked(monkeypatch, [300.0], exact, gain=29.0, asked=True).found) == 1
    assert Looked(monkeypatch, [300.0], exact, coloured=False).found == []
    assert len(Looked(monkeypatch, [300.0], exact, coloured=False, asked=True).found) == 1


def test_without_a_peak_a_stiff_shaft_is_what_was_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert Looked(monkeypatch, [], (0.6, 300.0)).found == []
    (one,) = Looked(monkeypatch, [], (0.6, 300.0), asked=True).found
    assert (one.start, one.gain) == ({}, pytest.approx(0.0))


def test_colour_in_any_channel_asks_for_a_look() -> None:
    white = RNG.standard_normal(4000)
    red = np.convolve(RNG.standard_normal(4010), np.ones(6), "valid")[:4000]
    for residual, coloured in ((white, False), (np.r_[white[:2000], red[:2000]], True)):
        one = SimpleNamespace(residual=residual, slices=(slice(0, 2000), slice(2000, 4000)))
        found: Any = SimpleNamespace(records=[one])
        assert shaft_resonance._is_coloured(found) is coloured


def test_peaks_are_of_all_channels_and_records() -> None:
    time = 1e-4 * np.arange(4000)
    noise = 0.1 * RNG.standard_normal(4000)
    waves = [np.sin(2 * np.pi * hz * time) + noise for hz in (100.0, 400.0)]
    m = SimpleNamespace(keep=np.arange(4000))
    records: Any = [
        SimpleNamespace(departures=lambda *_, w=w: [w, noise], measured=[m, m],
                        timeline=SimpleNamespace(period_s=1e-4)) for w in waves
    ]  # fmt: skip
    found: Any = SimpleNamespace(values=None, own=[None, None])
    peaks = shaft_resonance._resonances(records, found)
    assert peaks == pytest.approx([200 * np.pi, 800 * np.pi], rel=0.01)


def test_neighbours_reach_from_two_thirds_to_as_far_above() -> None:
    near = shaft_resonance._neighbours(30)
    assert (near.start, near.stop) == (20, 46)
    far = shaft_resonance._neighbours(3000)
    assert (far.start, far.stop) == (2900, 3101)


def test_a_slow_swing_and_noise_are_no_peaks() -> None:
    time = np.arange(4000) * 1e-4
    slow = np.sin(2 * np.pi * 4.0 / 0.4 * time)  # four times in the capture
    assert len(shaft_resonance._peaks(slow + 0.01 * RNG.standard_normal(4000), 0.4)) == 0
    four = sum(np.sin(2 * np.pi * hz * time) * a for hz, a in
               ((300, 1.0), (500, 2.0), (900, 3.0), (1500, 4.0)))  # fmt: skip
    found = shaft_resonance._peaks(four + 0.01 * RNG.standard_normal(4000), 0.4)
    assert sorted(found / 2 / np.pi) == pytest.approx([500, 900, 1500], rel=0.01)


@pytest.mark.parametrize(("power", "stands"), [(14.0, False), (45.0, True)])
def test_a_peak_stands_out_by_some_tens_of_its_neighbours_power(power: float, stands: bool) -> None:
    """Waves of all frequencies, as strong as each other, and one of so many times their power."""
    spectrum = np.exp(2j * np.pi * np.random.default_rng(8).random(2001))
    spectrum[400] *= np.sqrt(power)
    found = shaft_resonance._peaks(np.fft.irfft(spectrum), 1.0)
    assert found == pytest.approx([2 * np.pi * 400.0] if stands else [], rel=3e-3)
