"""The progress line: share, time left, live readings; silent away from a terminal."""

from __future__ import annotations

import pytest

from motorid.acquire.live import Live
from motorid.cli.progress import ProgressLine, render


def at(done_s: float, current_a: float | None = None, speed_rad_s: float | None = None) -> Live:
    """Some way into a run of ten seconds."""
    return Live(done_s, 10.0, current_a, speed_rad_s)


def test_shows_share_time_left_and_readings() -> None:
    line = render(at(2.5, current_a=-0.25, speed_rad_s=310.0), elapsed_s=5.0)
    assert "25%" in line
    assert "15 s left" in line  # at the pace so far, not the rig's own
    assert "-0.250 A" in line
    assert "+310.0 rad/s" in line


@pytest.mark.parametrize("done_s", [0.0, 10.0, 11.0])
def test_ends_of_a_run(done_s: float) -> None:
    line = render(at(done_s), elapsed_s=0.0)
    assert line.startswith("[")
    assert len(line.split("]")[0]) == 25


def test_says_nothing_where_stderr_is_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with ProgressLine() as progress:
        progress(at(1.0))
    assert capsys.readouterr().err == ""


def test_draws_over_itself_on_a_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    with ProgressLine() as progress:
        progress(at(0.1, current_a=1.0))
    text = capsys.readouterr().err
    assert text.count("\r") == 2
    assert "100%" in text
    assert text.endswith("\n")
