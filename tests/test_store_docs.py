"""docs/file-format.md is true: its example runs, and every attribute is in it."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.capture import store, store_layout
from motorid.capture.model import QUANTITIES, Capture, Channel, Wiring
from motorid.rig import load_rig


@pytest.fixture
def page(repo_root: Path) -> str:
    return (repo_root / "docs" / "file-format.md").read_text(encoding="utf-8")


def test_the_example_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = load_rig("sim")
    raw = np.arange(5, dtype=np.int16)
    current = Channel("current", "A", raw, scale=0.5, offset=1.0)
    capture = Capture(1600 * np.arange(5), 16e6, {"current": current}, provenance={"rig": rig.text})
    store.save(capture, tmp_path / "capture.h5")
    monkeypatch.chdir(tmp_path)
    found: dict[str, Any] = {}
    exec(re.findall(r"```python\n(.*?)```", page, re.DOTALL)[0], found)
    np.testing.assert_allclose(found["table"]["current [A]"], capture.channels["current"].values)
    np.testing.assert_allclose(found["table"]["time [s]"], capture.time_s)
    assert found["rig"] == rig.text


@pytest.mark.parametrize("kind", [Channel, Wiring, Capture])
def test_every_attribute_is_explained(kind: type, page: str) -> None:
    derived = {"name", "raw", "ticks", "channels", "sha256", "path"}
    for field in fields(kind):
        assert field.name in derived or f"`{field.name}`" in page or f"`{field.name}/`" in page


def test_every_quantity_and_version_is_named(page: str) -> None:
    for name, unit in QUANTITIES.items():
        assert f"`{name}` ({unit})" in page
    assert f"format {store_layout.MAJOR}.{store_layout.MINOR}" in page
