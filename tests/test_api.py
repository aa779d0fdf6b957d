"""The calls that README shows, from Python."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import motorid
from tests.acquire.rigs import SHORT


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    rig = motorid.load_rig("sim")
    fast = replace(rig, port=f"{rig.port}&speed=max", program=SHORT)
    return motorid.record(fast, tmp_path_factory.mktemp("api") / "run.h5", serial="M17")


@pytest.mark.slow
def test_record_then_fit_a_path_or_a_capture(path: Path) -> None:
    capture = motorid.load(path)
    assert capture.provenance["serial"] == "M17"
    by_path, by_capture = motorid.fit(path), motorid.fit(capture)
    assert by_path.parameters == by_capture.parameters == motorid.fit([path]).parameters
    assert by_path.parameters["K"].status == "estimated"
    six = motorid.fit(str(path), fix={"K": 0.0077}, model="six")
    assert six.parameters["K"].status == "fixed"


@pytest.mark.slow
def test_what_is_no_capture_is_said(path: Path) -> None:
    with pytest.raises(motorid.MotoridError, match="17 is no capture: give captures, or the files"):
        motorid.fit(path, 17)  # type: ignore[arg-type]


@pytest.mark.slow
def test_save_never_over_a_file_unasked(path: Path) -> None:
    with pytest.raises(motorid.MotoridError, match="exists"):
        motorid.save(motorid.load(path), path)


def test_public_names() -> None:
    assert set(motorid.__all__) <= set(dir(motorid))
    for name in motorid.__all__:
        assert getattr(motorid, name)
    with pytest.raises(AttributeError, match="no attribute 'fitt'"):
        motorid.fitt  # noqa: B018
