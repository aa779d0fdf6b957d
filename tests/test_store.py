"""Capture files: what is saved is loaded, plain tools open it, and a bad file is one sentence."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import fields
from dataclasses import replace as replace_fields
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from motorid.capture import store, store_layout, store_read
from motorid.capture.content_digest import seal
from motorid.capture.model import Capture, Channel, Gap, Phase, Wiring
from motorid.errors import DataError, UsageError
from motorid.program import Decay, Program, Step, StepKind

N = 400


@pytest.fixture
def capture() -> Capture:
    rng = np.random.default_rng(1)
    current = Channel(
        "current",
        "A",
        rng.integers(-2048, 2047, N).astype(np.int16),
        scale=1.7e-3,
        offset=3.25,
        kind="mean",
        aperture_s=50e-6,
        delay_s=5e-6,
        resolution=1.7e-3,
        noise=2e-3,
        gain_uncertainty=0.002,
        offset_uncertainty=1e-4,
        nonlinearity=0.003,
        nonlinearity_shape="bow",
        full_scale=3.0,
        ratiometric=True,
        raw_min=-2048,
        raw_max=2047,
    )
    voltage = Channel("terminal_voltage", "V", np.linspace(0, 6, N), sense="terminals")
    position = Channel("position", "rad", np.arange(N, dtype=np.int64) << 33, pwm_phase=0.25)
    return Capture(
        ticks=(1 << 40) + 1600 * np.arange(N, dtype=np.int64),
        clock_hz=16e6,
        clock_uncertainty=29e-6,
        channels={c.name: c for c in (current, voltage, position)},
        wiring=Wiring(
            bridge_resistance_ohm=0.1,
            counts_per_turn=2048,
            pwm_hz=20e3,
            reference_drift=1e-3,
            reference_time_s=2.0,
            encoder_eccentricity_rad=2e-3,
            terminal_load_ohm=22e3,
            terminal_load_uncertainty_ohm=1e3,
        ),
        program=Program((Step(StepKind.DRIVE_VOLTS, 0.1, 3.3, Decay.DIODE),)),
        phases=(Phase(0, 1 << 40),),
        gaps=(Gap(17, 3, "lost on the link"),),
        end_reason="fault: over_current",
        ambient_c=23.5,
        ambient_uncertainty_c=0.5,
        provenance={"rig": "name = 'Ω'", "identity": {"board": "sim"}, "serial": "M17", "note": ""},
    )


def test_what_is_saved_is_loaded(capture: Capture, tmp_path: Path) -> None:
    path = store.save(capture, tmp_path / "run.h5")
    loaded = store.load(path)
    for field in fields(Capture):
        if field.name not in ("ticks", "channels", "sha256", "content_sha256", "path"):
            assert getattr(loaded, field.name) == getattr(capture, field.name), field.name
    np.testing.assert_array_equal(loaded.ticks, capture.ticks)
    for name, channel in capture.channels.items():
        for field in fields(Channel):
            if field.name != "raw":
                found = getattr(loaded.channels[name], field.name)
                assert found == getattr(channel, field.name), field.name
        assert loaded.channels[name].raw.dtype == channel.raw.dtype
        np.testing.assert_array_equal(loaded.channels[name].raw, channel.raw)
    assert loaded.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    with h5py.File(path) as file:
        assert loaded.content_sha256 == file.attrs["content_sha256"] != ""
    assert loaded.path == str(path)


def test_an_empty_capture_is_saved_and_loaded(tmp_path: Path) -> None:
    empty = Capture(np.zeros(0, np.int64), 1e6, {"current": Channel("current", "A", np.zeros(0))})
    assert len(store.load(store.save(empty, tmp_path / "empty.h5"))) == 0


def test_the_same_capture_gives_the_same_bytes(capture: Capture) -> None:
    assert store.to_bytes(capture) == store.to_bytes(capture)


def test_plain_h5py_and_pandas_open_it(capture: Capture, tmp_path: Path) -> None:
    path = store.save(capture, tmp_path / "run.h5")
    with h5py.File(path) as file:
        table = pd.DataFrame({name: column[:] for name, column in file["samples"].items()})
        current = file["samples/current"]
        amperes = current.attrs["scale"] * (current[:] - current.attrs["offset"])
        assert current.attrs["unit"] == "A"
        assert file["provenance/rig"].asstr()[()] == "name = 'Ω'"
        assert file.attrs["clock_hz"] == 16e6
    assert list(table.columns) == ["current", "position", "terminal_voltage", "tick"]
    assert len(table) == N
    np.testing.assert_allclose(amperes, capture.channels["current"].values)


def test_nothing_is_overwritten_unasked(capture: Capture, tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    path.write_text("precious")
    with pytest.raises(UsageError, match="exists already"):
        store.save(capture, path)
    assert path.read_text() == "precious"
    store.save(capture, path, force=True)
    assert len(store.load(path)) == N
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_that_refuses_leaves_nothing(
    capture: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("motorid.capture.whole.os.fsync", full)
    with pytest.raises(DataError, match="No space left on device"):
        store.save(capture, tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == []


def test_more_than_can_be_read_is_not_written(
    capture: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(store, "CAPTURE", replace_fields(store.CAPTURE, rows=N - 1))
    with pytest.raises(DataError, match="400 samples are more than a capture may have"):
        store.save(capture, tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == []


def test_a_missing_folder_is_named(capture: Capture, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="does not exist"):
        store.save(capture, tmp_path / "nowhere" / "run.h5")


def replace(file: h5py.File, name: str, **made: object) -> None:
    del file[name]
    file.create_dataset(name, **made)


def external_link(file: h5py.File) -> None:
    del file["samples/current"]
    file["samples/current"] = h5py.ExternalLink("/etc/passwd", "x")


def soft_link(file: h5py.File) -> None:
    del file["samples/current"]
    file["samples/current"] = h5py.SoftLink("/samples/tick")


def external_storage(file: h5py.File) -> None:
    replace(file, "samples/current", shape=(N,), dtype="i2", external=[("/etc/passwd", 0, 2 * N)])


def virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout(shape=(N,), dtype="i2")
    layout[:] = h5py.VirtualSource("/tmp/other.h5", "x", shape=(N,))
    del file["samples/current"]
    file.create_virtual_dataset("samples/current", layout)


HOSTILE: dict[str, Callable[[h5py.File], object]] = {
    "points outside": external_link,
    "points outside the file": soft_link,
    "outside the file: refused": external_storage,
    "keeps its data outside": virtual,
    "claims more data": lambda f: replace(
        f, "samples/tick", shape=(10**13,), dtype="i8", chunks=(1024,)
    ),
    "not numbers": lambda f: replace(f, "samples/tick", data=["a"] * N),
    "not integers": lambda f: replace(f, "samples/tick", data=np.arange(float(N))),
    "does not increase": lambda f: replace(f, "samples/tick", data=np.zeros(N, np.int64)),
    "readings for": lambda f: replace(f, "samples/tick", data=np.arange(N + 1)),
    "1-dimensional": lambda f: replace(f, "samples/tick", data=np.zeros((N, 2), np.int64)),
    "does not read": lambda f: replace(f, "samples/tick", data=np.arange(N), compression="lzf"),
    "tick is missing": lambda f: f.__delitem__("samples/tick"),
    "samples is missing": lambda f: f.__delitem__("samples"),
    "samples is not a group": lambda f: (f.__delitem__("samples"), f.__setitem__("samples", 3)),
    "clock_hz has the wrong type": lambda f: f.attrs.__setitem__("clock_hz", np.ones(5)),
    "clock_hz must be above 0": lambda f: f.attrs.__setitem__("clock_hz", -1.0),
    "clock_hz is not a number": lambda f: f.attrs.__setitem__("clock_hz", np.nan),
    "capture format 2": lambda f: f.attrs.__setitem__("format_major", 2),
    "not a motorid capture": lambda f: f.attrs.__setitem__("format", "else"),
    "scale is 'x'": lambda f: f["samples/current"].attrs.__setitem__("scale", "x"),
    "has no scale": lambda f: f["samples/current"].attrs.__delitem__("scale"),
    "kind is 'odd'": lambda f: f["samples/current"].attrs.__setitem__("kind", "odd"),
    "nonlinearity_shape is 'z'": lambda f: f["samples/current"].attrs.__setitem__(
        "nonlinearity_shape", "z"
    ),
    "program is not text": lambda f: replace(f, "program", data=3),
    "program version": lambda f: replace(f, "program", data='{"version": 9}'),
    "not a readable capture": lambda f: replace(f, "program", data="[" * 10**5),
    "gaps lacks": lambda f: replace(f, "gaps", data=np.zeros(3)),
    "a gap lies outside": lambda f: replace(
        f, "gaps", data=np.array([(N + 1, 1, b"")], dtype=store_layout.GAPS)
    ),
}


@pytest.mark.parametrize("says", HOSTILE)
def test_a_hostile_file_is_one_sentence(says: str, capture: Capture, tmp_path: Path) -> None:
    path = store.save(capture, tmp_path / "run.h5")
    with h5py.File(path, "a") as file:
        del file.attrs["content_sha256"]  # so that nothing but what is wrong speaks
        file.attrs["format_minor"] = 0
        HOSTILE[says](file)
    with pytest.raises(DataError) as caught:
        store.load(path)
    assert says in str(caught.value)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_a_truncated_or_foreign_file_is_one_sentence(capture: Capture, tmp_path: Path) -> None:
    data = store.to_bytes(capture)
    path = tmp_path / "cut.h5"
    for cut in (0, 1, 96, 800, len(data) // 2, len(data) - 1):
        path.write_bytes(data[:cut])
        with pytest.raises(DataError, match="not a readable capture file"):
            store.load(path)
    path.write_bytes(b"time,current\n0,1\n")
    with pytest.raises(DataError, match="not a readable capture file"):
        store.load(path)
    with pytest.raises(DataError, match="cannot be read"):
        store.load(tmp_path / "absent.h5")


@pytest.mark.slow
def test_a_repacked_file_still_reads(capture: Capture, tmp_path: Path) -> None:
    """As h5repack with deflate leaves it."""
    path = store.save(capture, tmp_path / "run.h5")
    with h5py.File(path, "a") as file:
        for name in list(file["samples"]):
            values, facts = file["samples"][name][:], dict(file["samples"][name].attrs)
            replace(file, f"samples/{name}", data=values, compression="gzip", shuffle=True)
            file["samples"][name].attrs.update(facts)
    np.testing.assert_array_equal(store.load(path).ticks, capture.ticks)


def test_what_a_later_minor_adds_is_ignored(capture: Capture, tmp_path: Path) -> None:
    path = store.save(capture, tmp_path / "run.h5")
    with h5py.File(path, "a") as file:
        file.attrs["format_minor"] = 7
        file.attrs["something"] = 1.0
        file.create_group("more")
        file["samples/current"].attrs["colour"] = "red"
        seal(file)
    assert len(store.load(path)) == N


def test_a_file_of_an_earlier_minor_has_nothing_across_its_motor(
    capture: Capture, tmp_path: Path
) -> None:
    path = store.save(capture, tmp_path / "run.h5")
    with h5py.File(path, "a") as file:
        file.attrs["format_minor"] = 4
        for name in ("terminal_load_ohm", "terminal_load_uncertainty_ohm"):
            del file["wiring"].attrs[name]
        seal(file)
    wiring = store.load(path).wiring
    assert (wiring.terminal_load_ohm, wiring.terminal_load_s) == (0.0, 0.0)
    assert wiring.encoder_eccentricity_rad == capture.wiring.encoder_eccentricity_rad


@pytest.mark.slow
def test_no_edit_of_a_sealed_file_goes_unseen(capture: Capture, tmp_path: Path) -> None:
    """Not even one that leaves a capture which could be read."""
    edits: dict[str, Callable[[h5py.File], object]] = {
        **HOSTILE,
        "a value": lambda f: f["samples/position"].write_direct(np.arange(N) * 2),
        "a fact": lambda f: f["samples/current"].attrs.__setitem__("offset", 3.5),
        "a note": lambda f: replace(f, "provenance/note", data="x"),
        "an addition": lambda f: f.attrs.__setitem__("colour", "red"),
        "the digest": lambda f: f.attrs.__delitem__("content_sha256"),
        "a letter of the digest": lambda f: f.attrs.__setitem__("content_sha256", "0" * 64),
    }
    whole = store.save(capture, tmp_path / "whole.h5").read_bytes()
    for number, (name, edit) in enumerate(edits.items()):
        path = tmp_path / f"{number}.h5"
        path.write_bytes(whole)
        with h5py.File(path, "a") as file:
            edit(file)
        with pytest.raises(DataError) as caught:
            store_read.read(path.read_bytes(), str(path), "")
        assert "\n" not in str(caught.value), name
