"""What is said of a mechanical fit: each sentence at its bound, and what it rests on."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, TORQUE, VOLTAGE, Capture, Channel
from motorid.estimate.partial import mechanical_remarks as module
from motorid.estimate.partial.mechanical_signals import COMMAND
from motorid.estimate.partial.modulating_functions import SHAPES

Floats = NDArray[np.float64]
COUNT = 60


def regression(residual: Floats, shapes: Floats | None = None, **facts: Any) -> Any:
    rng = np.random.default_rng(2)
    n = len(residual)
    rows = SimpleNamespace(
        matrix=rng.standard_normal((n, 4)) * [1.0, 30.0, 0.1, 1.0], weight=np.full(n, 4.0),
        shapes=rng.standard_normal((n, 3)) if shapes is None else shapes,
        capture=np.arange(n) * 4 // n // 3,  # three quarters of the first
    )  # fmt: skip
    given = {
        "residual": residual, "rows": rows, "half_width_s": 0.05,
        "free": np.array([True, True, True, False]), "coefficients": np.array([3.0, 0, 0, 0]),
    }  # fmt: skip
    return SimpleNamespace(**{**given, **facts})


def motion(noise: float = 0.2, jumps: float = 0.0, inertia: float = 0.0, **facts: Any) -> Any:
    speed = np.array(facts.pop("speed", [0.0, 10.0, 20.0]))
    return SimpleNamespace(
        drive_noise=noise, period_s=0.01, jumps_variance=lambda half: jumps * half,
        inertia_noise=lambda half: inertia * half, drive_unit="A", drive_name="current_x",
        unsigned=False, top_speed=float(np.abs(speed).max()), speed=lambda _: speed, **facts,
    )  # fmt: skip


def test_rows_have_the_noise_of_their_captures_by_how_many_they_are() -> None:
    """Of the drive, of what lies between its readings, and of the speed through the inertia."""
    first, second = motion(0.2, 0.3, 0.4), motion(0.5)
    best = regression(np.zeros(COUNT))
    of_first = 0.2**2 * 0.01 + 0.3 * 0.05 + (3.0 * 0.4 * 0.05) ** 2
    of_second = 0.5**2 * 0.01
    expected = (0.75 * of_first + 0.25 * of_second) ** 0.5
    assert module.expected_rms([first, second], best) == pytest.approx(expected)
    more = (0.75 * (of_first + 2.0 * 0.3 * 0.05) + 0.25 * of_second) ** 0.5
    assert module.expected_rms([first, second], best, 3.0) == pytest.approx(more)


@pytest.mark.parametrize(("times", "lacks"), [(1.9, False), (2.1, True)])
def test_twice_the_variance_is_lack_of_fit(times: float, lacks: bool) -> None:
    expected = 0.2 * 0.01**0.5
    residual = np.tile([1.0, -1.0], COUNT // 2) * expected * times**0.5
    one = module._lack_of_fit([motion(), motion()], regression(residual))
    assert bool(one) is lacks
    if lacks:
        said = one[0].message
        assert (one[0].code, one[0].severity) == ("lack_of_fit", "warning")
        assert "the current x that the model leaves unexplained" in said
        assert f"({expected * times**0.5 / 4.0:.3g} A rms over 0.05 s) is 1.4 times what" in said


def test_jumps_at_an_end_of_their_interval_are_no_lack_of_fit() -> None:
    """Three times their variance, twice of which is none."""
    pair = [motion(0.0, 0.2), motion(0.0, 0.2)]
    for times, lacks in ((5.9, False), (6.1, True)):
        residual = np.tile([1.0, -1.0], COUNT // 2) * (times * 0.2 * 0.05) ** 0.5
        assert bool(module._lack_of_fit(pair, regression(residual))) is lacks
    silent = [motion(0.0), motion(0.0)]
    (said,) = module._lack_of_fit(silent, regression(np.ones(COUNT)))
    assert "is above what the noise" in said.message


@pytest.mark.parametrize("column", [0, 1, 2])
def test_the_term_that_explains_the_most_is_suspected(column: int) -> None:
    rng = np.random.default_rng(4)
    shapes = rng.standard_normal((COUNT, 3)) * [1e-4, 1.0, 1e3]
    residual = shapes[:, column] / shapes[:, column].std() + 0.3 * rng.standard_normal(COUNT)
    best = regression(residual, shapes)
    matrix = np.column_stack([best.rows.matrix[:, :3], shapes[:, column]])
    left = residual - matrix @ np.linalg.pinv(matrix, rcond=1e-12) @ residual
    share = 100.0 * (1.0 - left @ left / (residual @ residual))
    assert module._suspect(best, "current") == (
        f"Suspect: {SHAPES[column]}, which would explain {share:.0f} % of it."
    )


def test_what_no_term_explains_names_none() -> None:
    turning = np.tile([1.0, -1.0], 500)
    shapes = np.ones((1000, 3))
    best = regression(turning, shapes)
    assert module._suspect(best, "current").startswith(
        "No simple friction term explains it: suspect a load"
    )


@pytest.mark.parametrize(("jump", "slow"), [(2.9, False), (3.1, True)])
def test_a_speed_that_changes_by_much_between_two_samples_is_sampled_slowly(
    jump: float, slow: bool
) -> None:
    """Three tenths of its top."""
    speeds = [0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 10.0 - jump]
    found = module._slow_sampling([motion(), motion(speed=speeds)][1:])
    assert bool(found) is slow
    if slow:
        assert "by 31 % of its top value between two samples 10 ms apart" in found[0].message
        assert (found[0].code, found[0].severity) == ("slow_sampling", "warning")
    assert module._slow_sampling([motion(speed=[0.0, 0.0])]) == []


def test_one_magnitude_is_enough_to_be_said() -> None:
    plain, bare = motion(), motion()
    bare.unsigned = True
    assert module._unsigned([plain]) == []
    (said,) = module._unsigned([plain, bare])
    assert (said.code, said.severity) == ("unsigned_drive", "info")


def capture(gain: float = 0.0, notes: tuple[str, ...] = (), **more: tuple[str, float]) -> Capture:
    """At rest, then a rise to a level."""
    time = 1e-3 * np.arange(800)
    risen = 1.0 - np.exp(-np.maximum(time - 0.1, 0.0) / 0.05)
    channels = {SPEED: Channel(SPEED, "rad/s", 100.0 * risen, gain_uncertainty=gain)}
    for name, (unit, level) in more.items():
        channels[name] = Channel(name, unit, np.where(time > 0.1, level, 0.0))
    return Capture(
        np.arange(800) * 1000, 1e6, channels, provenance={"notes": notes} if notes else {}
    )


def test_notes_of_an_import_are_said_once_and_gains_where_nobody_declared_one() -> None:
    found = module.of_captures([capture(notes=("a", "b")), capture(notes=("b", "c"))])
    assert [d.message for d in found if d.code == "import"] == [
        "On import: a.", "On import: b.", "On import: c.",
    ]  # fmt: skip
    assert found[0].code == "identifiability"
    assert found[-1].code == "gain_undeclared"
    declared = module.of_captures([capture(), capture(gain=0.01)])
    assert "gain_undeclared" not in {d.code for d in declared}


def test_captures_that_stand_still_are_counted() -> None:
    assert module.standing_still(1).message.startswith("One capture was left out")
    assert module.standing_still(3).message.startswith("3 captures were left out")


@pytest.mark.parametrize(
    ("more", "told", "note"),
    [
        ({TORQUE: ("N·m", 0.1)}, "can determine B, J, T0 at best.", False),
        ({CURRENT: ("A", 1.0)}, "J/K, B/K, T0/K at best.", False),
        ({COMMAND: ("1", 0.5)}, "T0·R/K", True),
        ({VOLTAGE: ("V", 6.0)}, "T0·R/K", False),
    ],
)
def test_what_the_channels_can_tell_at_best_is_said(
    more: dict[str, tuple[str, float]], told: str, note: bool
) -> None:
    """Whatever the run itself has shown: at three levels, sampled finely."""
    said = module._knowable(capture(**more)).message
    names = ", ".join(sorted({SPEED, *more}))
    assert said.startswith(f"These channels ({names}) can determine ")
    assert told in said
    assert (", volts being in units of the command" in said) is note
    assert not said.endswith(" ")
