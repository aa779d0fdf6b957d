"""docs/file-format.md is true: its example runs, and every attribute is in it."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from motorid import json_seal, limits
from motorid.capture import store, store_layout
from motorid.capture.model import QUANTITIES, Capture, Channel, Gap, Phase, Wiring
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
    derived = {"name", "raw", "ticks", "channels", "sha256", "path", "stated"}
    for field in fields(kind):
        assert field.name in derived or f"`{field.name}`" in page or f"`{field.name}/`" in page


def test_every_quantity_and_version_is_named(page: str) -> None:
    for name, unit in QUANTITIES.items():
        assert f"`{name}` ({unit})" in page
    assert f"format {store_layout.MAJOR}.{store_layout.MINOR}" in page


def test_the_table_of_limits_is_the_one_in_force(page: str) -> None:
    assert limits.markdown() in page


def test_the_example_of_a_document_s_digest_holds(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    document = json_seal.sealed({"schema": "x", "Ω": [1e-7, 2.0, -0.0, 1e22, None], "b": {"a": 1}})
    (tmp_path / "estimate.json").write_text(json.dumps(document, indent=2), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    code = re.findall(r"```python\n(.*?)```", page, re.DOTALL)[1]
    exec(code, {})
    (tmp_path / "estimate.json").write_text(json.dumps(document | {"b": 2}), encoding="utf-8")
    with pytest.raises(AssertionError):
        exec(code, {})


def test_a_capture_s_digest_is_made_as_the_page_says(tmp_path: Path) -> None:
    """Written again from the page, for what this file holds."""
    made = hashlib.sha256()

    def part(data: bytes) -> None:
        made.update(len(data).to_bytes(8, "little") + data)

    def value(data: Any, dtype: np.dtype[Any], shape: tuple[int, ...]) -> None:
        if dtype.names:
            part(b"table")
            for name in dtype.names:
                part(name.encode())
                value(data[name], dtype[name], shape)
        elif h5py.check_string_dtype(dtype):
            part(b"text")
            part(str(shape).encode())
            for text in np.asarray(data, dtype=object).ravel():
                part(text.encode() if isinstance(text, str) else text.rstrip(b"\0"))
        else:
            part(dtype.str.encode())
            part(str(shape).encode())
            part(np.asarray(data, dtype=dtype).tobytes())

    current = Channel("current", "A", np.arange(5, dtype=np.int16), scale=0.5)
    capture = Capture(
        1600 * np.arange(5),
        16e6,
        {"current": current},
        phases=(Phase(0, 7),),
        gaps=(Gap(2, 1, "Ω"),),
        provenance={"note": "Ω", "rig": ""},
    )
    with h5py.File(store.save(capture, tmp_path / "run.h5")) as file:
        items: dict[str, Any] = {"": file}
        file.visititems(lambda name, item: items.__setitem__(f"/{name}", item))
        for path in sorted(items):
            item = items[path]
            part(b"dataset" if isinstance(item, h5py.Dataset) else b"group")
            part(path.encode())
            if isinstance(item, h5py.Dataset):
                value(item[()], item.dtype, item.shape)
            for name in sorted(set(item.attrs) - {"content_sha256"}):
                part(b"attribute")
                part(name.encode())
                handle = item.attrs.get_id(name)
                value(item.attrs[name], handle.dtype, handle.shape)
        assert file.attrs["content_sha256"] == made.hexdigest()
