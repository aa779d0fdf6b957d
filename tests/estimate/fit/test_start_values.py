"""Start values: from signals of a motor that scipy drove, and from those that tell too little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from motorid.errors import DataError
from motorid.estimate.fit import start_values
from motorid.estimate.fit.start_signals import Signals

R, L, K, B, J, T0 = 2.0, 4e-3, 0.05, 4e-5, 2e-4, 6e-3
TRUTH = {"R": R, "L": L, "K": K, "B": B, "J": J, "T0": T0}
NEAR = 0.05  # of a start value; the charge of a window is taken at its ends
PERIOD_S, STEP, COAST, SERIES_OHM = 1e-4, 6000, 4000, 0.3


def driven(volts: float, sign: float) -> Signals:
    """A rest, a step of voltage and a coast with the bridge open; instants, without noise."""

    def on(_: float, y: np.ndarray) -> list[float]:
        i, w, _angle = y
        return [(volts - (R + SERIES_OHM) * i - K * w) / L, (K * i - B * w - sign * T0) / J, w]

    def off(_: float, y: np.ndarray) -> list[float]:
        return [(-B * y[0] - sign * T0) / J, y[0]]

    times = PERIOD_S * np.arange(STEP + 1)
    up = solve_ivp(
        on, (0, times[-1]), [0, 0, 0], t_eval=times, rtol=1e-9, atol=1e-12, max_step=1e-3
    )
    down = solve_ivp(
        off, (0, COAST * PERIOD_S), up.y[1:, -1], t_eval=PERIOD_S * np.arange(1, COAST + 1),
        rtol=1e-9, atol=1e-12,
    )  # fmt: skip
    rest = np.zeros(100)
    return Signals(
        PERIOD_S,
        np.concatenate([rest, np.full(STEP, volts), np.zeros(COAST)]),
        np.concatenate([rest, up.y[0, 1:], np.zeros(COAST)]),
        np.concatenate([rest, up.y[2, 1:], down.y[1]]),
        None,
        (0, 100, 100 + STEP, 100 + STEP + COAST),
        (False, False, True),
        SERIES_OHM,
    )


@pytest.fixture(scope="module")
def both() -> list[Signals]:
    """One run each way, at two levels: what tells B and T0 apart."""
    return [driven(12.0, 1.0), driven(-7.0, -1.0)]


def electrical(data: list[Signals], **fixed: float) -> dict[str, float]:
    return dict(zip("RLK", start_values._electrical(data, fixed), strict=True))


def mechanical(data: list[Signals], **fixed: float) -> dict[str, float]:
    return dict(zip(("B", "J", "T0"), start_values.mechanical(data, K, fixed), strict=True))


@pytest.mark.slow
def test_windows_of_the_voltage_give_the_winding(both: list[Signals]) -> None:
    found = electrical(both)
    assert found["R"] == pytest.approx(R, rel=0.01)
    assert found["K"] == pytest.approx(K, rel=0.01)
    assert found["L"] == pytest.approx(L, rel=0.1)


def test_what_is_known_is_taken_and_what_is_not_follows(both: list[Signals]) -> None:
    found = electrical(both, R=1.1 * R, L=L)
    assert (found["R"], found["L"]) == (1.1 * R, L)
    assert found["K"] < 0.999 * K  # more is left to the resistance
    assert electrical(both, R=R, L=L)["K"] == pytest.approx(K, rel=1e-3)
    assert electrical(both, R=R, L=L, K=0.04)["K"] == 0.04
    assert electrical(both, L=0.0)["L"] == 0.0


def test_windows_of_the_torque_give_inertia_and_friction(both: list[Signals]) -> None:
    found = mechanical(both)
    assert found["J"] == pytest.approx(J, rel=NEAR)
    assert found["B"] == pytest.approx(B, rel=NEAR)
    assert found["T0"] == pytest.approx(T0, rel=NEAR)


def test_a_measured_speed_serves_as_well(both: list[Signals]) -> None:
    speeds = [replace(s, speed=np.gradient(s.angle, PERIOD_S)) for s in both]
    found = mechanical(speeds)
    for name in ("J", "B", "T0"):
        assert found[name] == pytest.approx(TRUTH[name], rel=NEAR)


@pytest.mark.parametrize("name", ["B", "J", "T0"])
def test_a_known_part_of_the_torque_is_taken(both: list[Signals], name: str) -> None:
    found = mechanical(both, **{name: TRUTH[name]})
    assert found[name] == TRUTH[name]
    for other in {"B", "J", "T0"} - {name}:
        assert found[other] == pytest.approx(TRUTH[other], rel=NEAR)


def test_friction_is_never_negative(both: list[Signals]) -> None:
    helped = [  # a torque that grows with the speed: viscous friction of the wrong sign
        replace(s, current=s.current - 2 * B / K * np.gradient(s.angle, PERIOD_S)) for s in both[:1]
    ]
    found = mechanical([replace(helped[0], edges=(0, 100, 6100), open=(False, False))])
    assert found["B"] == 0.0
    assert found["T0"] >= 0.0
    assert found["J"] > 0.0


@pytest.mark.parametrize("per_turn", [8, 16, 32])
def test_windows_are_as_wide_as_the_steps_of_an_encoder_ask(
    both: list[Signals], per_turn: int
) -> None:
    """At 225 rad/s: 0.3 to 1.2 steps a sample."""
    step = 2 * np.pi / per_turn
    counted = [replace(s, angle=step * np.floor(s.angle / step)) for s in both]
    assert mechanical(counted)["J"] < 0.5 * J  # noise of the speeds hides it
    known = mechanical([replace(s, step_rad=step) for s in counted])
    assert known["J"] == pytest.approx(J, rel=0.15)


def test_how_much_of_the_torque_is_explained(both: list[Signals]) -> None:
    _, explained = start_values.balanced(both, K, {})
    rows = np.array([row for s in both for row in start_values._torque_windows(s, K)])
    assert explained == pytest.approx(float(rows[:, 0] @ rows[:, 0]), rel=NEAR)


def test_noise_that_hides_the_back_emf_leaves_a_small_constant(both: list[Signals]) -> None:
    volts = [replace(s, volts=(R + SERIES_OHM) * s.current) for s in both]  # none at all
    found = electrical([replace(s, angle=1e-3 * s.angle) for s in volts])
    assert found["K"] > 0.0


def test_a_motor_that_turns_against_its_voltage_is_named(both: list[Signals]) -> None:
    with pytest.raises(DataError, match="reverse the encoder"):
        electrical([replace(s, angle=-s.angle) for s in both])


def test_without_a_step_there_is_nothing_to_begin_with(both: list[Signals]) -> None:
    idle = replace(both[0], volts=np.zeros_like(both[0].volts), current=0.0 * both[0].current)
    with pytest.raises(DataError, match="never driven"):
        electrical([replace(idle, angle=0.0 * idle.angle)])


def test_without_motion_there_is_no_inertia(both: list[Signals]) -> None:
    with pytest.raises(DataError, match="did not move"):
        mechanical([replace(both[0], angle=0.0 * both[0].angle)])
    with pytest.raises(DataError, match="does not follow the current"):
        mechanical([replace(s, current=-s.current) for s in both])


# windows


def even(n: int = 200, angle: np.ndarray | None = None) -> Signals:
    """A steady drive of one part."""
    turned = 0.01 * np.arange(float(n)) if angle is None else angle
    return Signals(PERIOD_S, np.full(n, 6.0), np.full(n, 0.5), turned, None, (0, n), (False,), 0.3)


def test_windows_of_the_voltage_double_up_to_a_quarter_of_their_part() -> None:
    """∫v, ∫i, Δi, Δangle over the root of their time, which says how long each is."""
    s = even(401)
    rows = np.array(list(start_values._voltage_windows(s)))
    lengths = np.rint((rows[:, 1] / 0.5) ** 2 / PERIOD_S).astype(int)
    assert lengths.tolist() == [1, 2, 4, 8, 16, 32, 64, 100, 100, 73]
    assert lengths.sum() == 400
    assert rows[:, 0] == pytest.approx((6.0 - 0.3 * 0.5) / 0.5 * rows[:, 1])
    assert rows[:, 3] == pytest.approx(0.01 / PERIOD_S / 0.5 * rows[:, 1])
    short = even(4)
    assert len(list(start_values._voltage_windows(short))) == 3
    opened = replace(s, open=(True,))
    assert list(start_values._voltage_windows(opened)) == []


def test_a_part_begins_where_the_one_before_it_ended() -> None:
    s = replace(even(401), edges=(0, 201, 401), open=(False, True))
    rows = list(start_values._voltage_windows(s))
    assert sum((row[1] / 0.5) ** 2 / PERIOD_S for row in rows) == pytest.approx(200)
    s = replace(s, open=(True, False))
    rows = list(start_values._voltage_windows(s))
    lengths = [round((row[1] / 0.5) ** 2 / PERIOD_S) for row in rows]
    assert lengths == [1, 2, 4, 8, 16, 32, 49, 49, 39]  # up to a quarter of 199, of its own part


def test_the_top_speed_is_of_a_window_and_not_of_one_reading() -> None:
    still = np.cumsum(np.r_[np.zeros(100), np.full(100, 0.02), np.zeros(100)])
    assert start_values._top_speed(even(300, still)) == pytest.approx(0.02 / PERIOD_S)
    jump = np.r_[np.zeros(150), np.full(150, 0.06)]  # over six readings
    assert start_values._top_speed(even(300, jump)) == pytest.approx(0.06 / (6 * PERIOD_S))
    assert start_values._top_speed(even(2001, -0.01 * np.arange(2001.0))) == pytest.approx(100.0)
    assert start_values._top_speed(even(6)) == 0.0
    assert start_values._top_speed(even(7)) > 0.0


def test_windows_of_the_torque_are_of_a_motor_that_surely_turns_one_way() -> None:
    rows = np.array(list(start_values._torque_windows(even(481), 0.04)))
    time = (rows[:, 3] ** 2).tolist()
    assert time == pytest.approx([20 * PERIOD_S] * len(rows))
    assert rows[:, 0] == pytest.approx(0.04 * 0.5 * rows[:, 3])
    assert rows[:, 1] == pytest.approx(0.0, abs=1e-9)
    assert rows[:, 2] == pytest.approx(100.0 * rows[:, 3])
    back = np.array(list(start_values._torque_windows(even(481, -0.01 * np.arange(481.0)), 0.04)))
    assert back[:, 3] == pytest.approx(-rows[:, 3])
    turns = np.abs(np.arange(481.0) - 240) * 0.01
    both = np.array(list(start_values._torque_windows(even(481, turns), 0.04)))
    assert len(both) < len(rows)  # not the one in which it turns round
    assert set(np.sign(both[:, 3])) == {1.0, -1.0}
    assert list(start_values._torque_windows(even(481, np.zeros(481)), 0.04)) == []


@pytest.mark.parametrize(("share", "counts"), [(0.5e-3, False), (2e-3, True)])
def test_a_motor_that_hardly_turns_may_be_held_by_friction(share: float, counts: bool) -> None:
    fast, slow = np.arange(240.0) * 0.01, np.arange(241.0) * 0.01 * share
    angle = np.r_[fast, fast[-1] + slow]
    late = [r for r in start_values._torque_windows(even(481, angle), 0.04)
            if r[2] / r[3] < 5e-3 * 100.0]  # fmt: skip
    assert bool(late) is counts


def test_a_window_counts_where_its_motor_surely_turns_at_both_ends() -> None:
    """Twelve marks as good as at rest, then eleven at speed: ten windows lie between those."""
    speed = np.where(np.arange(481) < 240, 0.05, 100.0)
    rows = list(start_values._torque_windows(replace(even(481), speed=speed), 0.04))
    assert len(rows) == 10
    assert all(row[1] == 0.0 for row in rows)


def test_a_window_of_the_torque_begins_where_the_part_before_it_ended() -> None:
    """Of a rotor that speeds up evenly, the speed in its mean tells where a window lies."""
    s = replace(even(481, 5e-4 * np.arange(481.0) ** 2), edges=(0, 201, 481), open=(False,) * 2)
    rows = np.array(list(start_values._torque_windows(s, 0.04)))
    times = np.sign(rows[:, 3]) * rows[:, 3] ** 2 / PERIOD_S
    middles = rows[:, 2] / rows[:, 3] * PERIOD_S / 1e-3
    later = middles[middles > 200.0]
    # 200 + 5 is the first mark, 11 to the next
    assert times[-1] == pytest.approx(11.0)
    assert later[0] == pytest.approx(205.0 + 5.5)
    assert np.diff(later) == pytest.approx(11.0)


def test_a_measured_speed_is_its_mean_about_a_mark() -> None:
    speed = np.arange(100.0)
    s = replace(even(100), speed=speed)
    assert start_values._speed_at(s, 50, 20) == pytest.approx(50.0)
    bent = replace(s, speed=speed**2)
    assert start_values._speed_at(bent, 50, 20) == pytest.approx(np.mean(speed[45:56] ** 2))
    assert start_values._speed_at(even(100), 50, 20) == pytest.approx(100.0)


def test_of_all_sets_of_columns_the_best_that_is_positive_is_taken() -> None:
    from scipy.optimize import nnls

    rng = np.random.default_rng(2)
    for _ in range(20):
        columns, target = rng.standard_normal((30, 3)), rng.standard_normal(30)
        found = start_values._non_negative(columns, target)
        assert found == pytest.approx(nnls(columns, target)[0], abs=1e-9)
