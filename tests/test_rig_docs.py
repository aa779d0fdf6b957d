"""docs/rig-file.md names every key, and its examples are rigs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from motorid.program import Rotor
from motorid.rig_file import TOP, parse
from motorid.rig_keys import CALIBRATION, CALIBRATION_FILE, CHANNELS, HELD, SECTIONS, STEP


@pytest.fixture
def page(repo_root: Path) -> str:
    return (repo_root / "docs" / "rig-file.md").read_text(encoding="utf-8")


def test_every_key_is_explained(page: str) -> None:
    keys = [key for section in SECTIONS.values() for key in section]
    for key in (*keys, *HELD, *CALIBRATION, *CALIBRATION_FILE, *CHANNELS):
        assert f"`{key}`" in page, key
    for key in (*STEP, *TOP):
        assert re.search(rf"\b{key} =", page), key


def test_the_examples_are_a_rig(page: str) -> None:
    bench, steps, held = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    rig = parse(bench + steps)
    assert rig.name == "bench 3"
    assert parse(bench + held).program.rotor is Rotor.CLAMPED
    assert len(rig.program.steps) == 2
    assert len(parse(bench).program.steps) == 8  # the derived one
