"""Scales by a nameplate and faults by the readings: which is looked for, and which is said."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis import suspects as room
from motorid.estimate.diagnosis.faults import unstated_channels
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.fit.logs.log_lags import TAKEN
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.signals.intersample_voltage import Rival
from motorid.estimate.solver.problem import Solution, Unknown

PERIOD_S = 1e-3
STATED: Any = {"R": SimpleNamespace(value=4.0), "L": SimpleNamespace(value=None)}
BARE: Any = {"R": SimpleNamespace(value=2.0), "L": SimpleNamespace(value=3.0)}


def suspect(code: str, strength: str = "named", allowed: bool = False) -> Suspect:
    return Suspect(code, "here", "so", "do", strength, allowed=allowed)  # type: ignore[arg-type]


class Given:
    """What scales and faults are found; which were asked for."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, absurd: tuple[bool, bool] = (False, False),
        named: bool = False, found: tuple[Suspect, ...] = (), direct: tuple[Suspect, ...] = (),
    ) -> None:  # fmt: skip
        self.asked = list[Any]()
        self.absurd, self.named = list(absurd), named
        scales = room.scale_errors
        monkeypatch.setattr(scales, "read_nameplate", lambda _: {"R": 1.0})
        monkeypatch.setattr(scales, "absurd", lambda *_: self.absurd.pop(0))
        monkeypatch.setattr(scales, "suspects", self.scales)
        monkeypatch.setattr(room, "without_loss", self.without_loss)
        monkeypatch.setattr(room.rank, "direct", lambda _: list(direct))
        monkeypatch.setattr(room.rank, "suspects", lambda *_: (found, "convicted"))

    def without_loss(self, records: Any, parameters: Any) -> Any:
        assert [list(record.volts) for record in records] == [[3.0, -9.0]]
        assert parameters == STATED
        return BARE

    def scales(self, parameters: Any, plate: Any, *top: float, turned: Any = None) -> Any:
        self.asked.append((parameters, plate, *top, turned))
        return (suspect("scale", "named" if self.named else "not excluded"),)

    def of(self, channel: str = POSITION, tried: bool = True) -> Any:
        record = SimpleNamespace(
            capture=SimpleNamespace(stated=SimpleNamespace(nameplate={}), channels={channel: 1}),
            volts=np.array([3.0, -9.0]),
        )
        record.twin = lambda: record
        records: Any = [record]
        nothing: Any = None
        found, convicted = room.suspects(records, nothing, STATED, tried)
        return [one.code for one in found], convicted


def test_faults_come_before_scales_that_nothing_excludes(monkeypatch: pytest.MonkeyPatch) -> None:
    given = Given(monkeypatch, found=(suspect("lag", allowed=True),), direct=(suspect("lost"),))
    assert given.of() == (["lag", "scale"], "convicted")
    assert given.asked == [(STATED, {"R": 1.0}, 9.0, True, STATED, None)]
    assert Given(monkeypatch, direct=(suspect("lost"),)).of(tried=False) == (
        ["lost", "scale"],
        None,
    )
    speed = Given(monkeypatch)
    speed.of(SPEED)
    assert speed.asked[0][3] is False


def test_a_fault_that_spoils_the_parameters_says_nothing_of_scales(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given = Given(monkeypatch, found=(suspect("lost"),))
    assert given.of() == (["lost", "scale"], "convicted")
    assert given.asked[1] == (STATED, {}, True)


def test_an_absurd_motor_is_a_scale_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    given = Given(monkeypatch, (True, True), named=True, found=(suspect("lag"),))
    assert given.of() == (["scale"], None)
    assert given.asked[0][0] == BARE
    assert given.asked[0][4] == STATED  # which a scale that is seen without them moves
    vague = Given(monkeypatch, (True, True), found=(suspect("lag"),))
    assert vague.of()[0] == ["lag", "scale"]
    mended = Given(monkeypatch, (True, False), named=True, found=(suspect("lag"),))
    assert mended.of()[0] == ["lag", "scale"]


# channels of a log


@pytest.fixture(autouse=True)
def _no_noise_of_a_voltage(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unstated_channels, "foreseen", lambda *_: iter(()))


@pytest.mark.parametrize(("moved_s", "said"), [(1e-4, 1), (2e-4, 0)])
def test_noise_of_the_voltage_makes_a_lag_less_sure(
    moved_s: float, said: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of .5 ms, by .01 of its own and by what two draws move it."""
    steps = [SimpleNamespace(own=np.array([moved_s / 2**0.5])) for _ in range(2)]
    monkeypatch.setattr(unstated_channels, "foreseen", lambda *_: iter(steps))
    lag = log(Instance(CURRENT_LAG))
    assert len(unstated_channels.suspects([lag], solution([5e-4]))) == said


def solution(*own: list[float], sd: float = 1e-5) -> Solution:
    covariance = tuple(np.eye(len(one)) * sd**2 for one in own)
    return Solution(
        (Unknown("R", 1.0),), np.ones(1), tuple(np.array(one) for one in own), covariance,
        np.eye(1), np.zeros(1, dtype=bool), tuple, 0.0, 1, True,
    )  # fmt: skip


def log(*instances: Any, taken_s: float = 0.0, window_s: float = 0.0, names: Any = (CURRENT, SPEED),
        undeclared: Any = ("aperture",)) -> Any:  # fmt: skip
    kind: Any = "mean" if window_s else "instant"
    current = Channel(CURRENT, "A", np.zeros(4), kind=kind, aperture_s=window_s,
                      undeclared=undeclared)  # fmt: skip
    capture = Capture(np.arange(4), 1e3, {CURRENT: current}, provenance={TAKEN: taken_s})
    blocks = {n: SimpleNamespace(channel=current) for n in names}
    return SimpleNamespace(
        instances=instances, capture=capture, as_stamped={"R": 7.0}, block=blocks.get,
        found=frozenset(), rivals=(), measured=[SimpleNamespace(values=np.zeros(100))],
        sensed=SimpleNamespace(
            waveform=SimpleNamespace(period_s=PERIOD_S, shape="joined", steps_off=np.arange(3))
        ),
    )  # fmt: skip


def named(*records: Any, found: Solution | None = None) -> dict[str, str]:
    said = unstated_channels.suspects(list(records), found or solution(*[[] for _ in records]))
    assert all(one.allowed and one.without == {"R": 7.0} for one in said)
    return {one.code: one.evidence for one in said}


def test_of_several_runs_the_largest_size_is_said() -> None:
    lag, smooth = Instance(CURRENT_LAG), Instance(SPEED_SMOOTHING)
    records = [log(lag, smooth), log(lag, smooth)]
    found = named(*records, found=solution([2e-3, 1e-3], [4e-3, 5e-4]))
    assert found == {
        "current_lag": "the current comes 4 ms (4 samples of the log) later than the other "
                       "channels; the fit allows for it",
        "speed_filtered": "the speed reads as behind a low-pass of 1 ms (1 samples of the log); "
                          "the fit allows for it",
    }  # fmt: skip
    assert named(*records, found=solution([2e-4, 1e-4], [1e-4, 1e-4])) == {}
    board = log(lag)
    board.sensed.waveform = None
    assert named(board, found=solution([4e-3])) == {}


@pytest.mark.parametrize(
    ("late_s", "behind", "said"),
    [
        (0.39e-3, 4.9, False),  # ln 150 = 5.01; .4 samples are worth saying
        (0.39e-3, 5.1, True),
        (-0.41e-3, 0.0, True),
        (float("nan"), 0.0, True),  # it had no lag among its unknowns
    ],
)
def test_a_lag_is_there_under_every_shape_of_the_voltage_that_is_as_likely(
    late_s: float, behind: float, said: bool
) -> None:
    one = log(Instance(VOLTAGE_LATE))
    one.measured = [SimpleNamespace(values=np.zeros(n)) for n in (100, 50)]
    one.rivals = (Rival(np.ones(1), 99.0, 0.0), Rival(np.ones(1), behind, late_s))
    assert ("voltage_lag" in named(one, found=solution([-0.5e-3]))) is said


@pytest.mark.parametrize(
    ("shape", "late_s", "jumps", "said"),
    [
        ("held", 0.5e-3, 3, False), ("broken", 0.99e-3, 3, False), ("loose", 0.5e-3, 3, False),
        ("sourced", 0.5e-3, 3, False), ("joined", 0.5e-3, 3, True), ("means", 0.5e-3, 3, True),
        ("held", 1.02e-3, 3, False), ("held", 1.04e-3, 3, True), ("held", 0.5e-3, 0, True),
    ],
)  # fmt: skip
def test_a_jump_that_the_next_reading_shows_is_no_lag(
    shape: str, late_s: float, jumps: int, said: bool
) -> None:
    one = log(Instance(VOLTAGE_LATE))
    one.sensed.waveform.shape, one.sensed.waveform.steps_off = shape, np.arange(jumps)
    found = named(one, found=solution([-late_s], sd=0.01e-3))
    assert ("voltage_lag" in found) is said


def test_a_current_taken_earlier_and_one_of_means_are_said_once() -> None:
    found = named(log(taken_s=3e-3), log(taken_s=2e-3))
    assert list(found) == ["current_lag"]
    assert "comes 3 ms (3 samples of the log) later" in found["current_lag"]
    means = named(log(window_s=5e-3), log(window_s=7e-3))
    assert means == {
        "current_averaged": "the current reads as a running mean over 5 ms (5 samples of the log); "
                            "the fit allows for it"
    }  # fmt: skip
    assert named(log(window_s=1e-3)) == {}  # since the reading before: nothing to say
    assert named(log(window_s=5e-3, undeclared=())) == {}
    assert named(log(window_s=5e-3, names=(SPEED,))) == {}


def test_what_another_filter_may_move_is_said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unstated_channels.filter_rest, "moves", lambda *_: {"R": 0.1})
    lag, smooth = Instance(CURRENT_LAG), Instance(SPEED_SMOOTHING)
    said = unstated_channels.suspects([log(lag, smooth)], solution([2e-3, 1e-3]))
    assert [(one.code, dict(one.moves)) for one in said] == [
        ("current_lag", {}),
        ("speed_filtered", {"R": 0.1}),
    ]
    assert "show that it is another" in said[1].evidence
    assert unstated_channels.suspects([log(lag)], solution([1e-5])) == []


def test_without_a_current_the_later_of_two_is_late() -> None:
    sizes = {VOLTAGE_LATE.name: (-2e-3, 1e-5)}
    found = {s.channel: s.seconds for s in unstated_channels.lags(log(names=(SPEED,)), sizes)}
    assert found == pytest.approx({VOLTAGE: 2e-3, SPEED: 0.0})
    turned = {s.channel for s in unstated_channels.lags(log(names=(CURRENT, POSITION)), sizes)}
    assert turned == {VOLTAGE, CURRENT, POSITION}
