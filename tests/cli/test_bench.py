"""How the command line adjusts a rig, and what it calls the files of several runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from motorid.errors import RigError, UsageError
from motorid.workflow import record
from motorid.workflow.record import bench, numbered


def test_speed_becomes_an_option_of_the_simulated_port() -> None:
    plain = bench("sim")
    fast = bench("sim", speed="max")
    assert fast.port.startswith(plain.port)
    assert "speed=max" in fast.port
    assert bench("sim", port="sim://?seed=7&speed=max", speed="realtime").port == (
        "sim://?seed=7&speed=realtime"
    )


def test_a_real_port_has_its_own_pace() -> None:
    assert bench("sim", port="/dev/ttyACM0").port == "/dev/ttyACM0"
    with pytest.raises(UsageError, match="its own pace"):
        bench("sim", port="/dev/ttyACM0", speed="max")


def test_unknown_rig() -> None:
    with pytest.raises(RigError):
        bench("no-such-rig")


def test_one_file_a_run() -> None:
    assert numbered(Path("a/run.h5"), 1) == [Path("a/run.h5")]
    assert numbered(Path("a/run.h5"), 2) == [Path("a/run-1.h5"), Path("a/run-2.h5")]


def test_nothing_moves_where_the_last_of_several_files_exists(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("motorid.acquire.record.open_port", opened.append)
    (tmp_path / "run-3.h5").write_bytes(b"precious")
    with pytest.raises(UsageError, match=r"run-3\.h5"):
        record.capture_runs(bench("sim"), tmp_path / "run.h5", repeat=3)
    assert opened == []
    assert [path.name for path in tmp_path.iterdir()] == ["run-3.h5"]
