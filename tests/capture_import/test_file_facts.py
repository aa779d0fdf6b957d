"""What a capture file says and what holds where it is silent; one fact changed at a time."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from motorid.capture import content_digest, store, store_guard, store_pack, store_read
from motorid.capture.content_digest import content_sha256
from motorid.capture.model import Capture, Channel, Gap, Phase, Stated, Wiring
from motorid.capture.store_guard import Guard
from motorid.errors import DataError
from motorid.program import Decay, Program, Step, StepKind

NAN = float("nan")
GAPS = [("index", "i8"), ("samples", "i8"), ("reason", "S9")]


def made() -> Capture:
    """A capture whose every number is its own."""
    numbers = {
        f.name: 0.125 + index for index, f in enumerate(fields(Wiring)) if f.name != "gear_ratio"
    }
    current = Channel(
        "current", "A", np.array([3, 4, 6], np.int16), 0.5, 1.5, "mean", 1e-3, 2e-3, 0.25, 0.5,
        0.75, 0.01, 0.02, 0.03, 4e-3, 2, 0.6, ("offset", "delay"), -9.0, 9.0, None, True, 0.003,
        "s", 20.0, True, 0.0625,
    )  # fmt: skip
    volts = Channel("terminal_voltage", "V", np.array([0.5, 1.5, np.nan]), sense="bridge")
    return Capture(
        ticks=np.array([5, 15, 2**40]), clock_hz=1e6,
        channels={"current": current, "terminal_voltage": volts}, clock_uncertainty=1e-5,
        wiring=Wiring(gear_ratio=3.5, **numbers),
        program=Program((Step(StepKind.DRIVE_VOLTS, 0.5, -2.0, Decay.DIODE),)),
        phases=(Phase(0, 5), Phase(1, 15)), gaps=(Gap(2, 7, "löst"), Gap(3, 1, "")),
        end_reason="stopped", ambient_c=-4.5, ambient_uncertainty_c=0.5,
        provenance={"serial": "7", "rig": "", "notes": ["a"], "held": {"current": 3}},
    )  # fmt: skip


def changed(change: Callable[[h5py.File], Any], minor: int | None = 0) -> Capture:
    """The capture read from a file that was changed and carries no digest."""
    image = io.BytesIO(store.to_bytes(made()))
    with h5py.File(image, "r+") as file:
        del file.attrs["content_sha256"]
        if minor is not None:
            file.attrs["format_minor"] = minor
        change(file)
    return store_read.read(image.getvalue(), "run.h5", "abc", own=True)


def same(a: Capture, b: Capture) -> None:
    """Raises where they differ in a fact, a reading or the type of one."""
    for name in ("channels", "ticks", "sha256", "content_sha256", "path"):
        if name == "ticks":
            np.testing.assert_array_equal(a.ticks, b.ticks)
        elif name == "channels":
            assert list(a.channels) == list(b.channels)
            for one, other in zip(a.channels.values(), b.channels.values(), strict=True):
                np.testing.assert_array_equal(one.raw, other.raw)
                assert one.raw.dtype == other.raw.dtype
                assert replace(one, raw=b"") == replace(other, raw=b"")  # type: ignore[arg-type]
    plain = {"channels": {}, "ticks": (), "sha256": "", "content_sha256": "", "path": ""}
    assert replace(a, **plain) == replace(b, **plain)


def test_all_that_a_capture_says_is_in_its_file_and_in_its_pack() -> None:
    capture = made()
    found = store_read.read(store.to_bytes(capture), "run.h5", "abc")
    same(capture, found)
    assert (found.path, found.sha256, len(found.content_sha256)) == ("run.h5", "abc", 64)
    again = store_pack.unpack(store_pack.pack(found))
    same(found, again)
    assert (again.path, again.sha256, again.content_sha256) == (
        found.path, found.sha256, found.content_sha256,
    )  # fmt: skip


def test_a_capture_that_says_little_is_packed_as_it_is() -> None:
    bare = Capture(np.array([1]), 1e3, {})
    same(bare, store_pack.unpack(store_pack.pack(bare)))
    rig = replace(bare, provenance={"rig": "[nameplate]\nresistance_ohm = 2"})
    assert store_pack.unpack(store_pack.pack(rig)).stated == Stated({"resistance_ohm": 2.0})


@pytest.mark.parametrize(
    ("broken", "named"), [("", "the root"), ("/samples/tick", "/samples/tick")]
)
def test_a_part_that_cannot_be_read_is_damage(
    broken: str, named: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    image, parts = store.to_bytes(made()), content_digest._parts

    def failing(path: str, item: Any) -> Any:
        if path == broken:
            raise OSError("wrong checksum\nat a place of memory")
        return parts(path, item)

    monkeypatch.setattr(content_digest, "_parts", failing)
    with h5py.File(io.BytesIO(image)) as file:
        assert "samples/tick" in file
        with pytest.raises(DataError) as caught:
            content_sha256(file, len(image))
    assert str(caught.value) == f"{named} is damaged (wrong checksum)"


def test_what_a_file_is_silent_about_has_its_usual_value() -> None:
    def silent(file: h5py.File) -> None:
        for name in list(file.attrs):
            if name not in ("format", "format_major", "clock_hz"):
                del file.attrs[name]
        for name in list(file["wiring"].attrs):
            del file["wiring"].attrs[name]
        for name in list(file["samples/current"].attrs):
            if name != "scale":
                del file["samples/current"].attrs[name]
        del file["program"]

    found = changed(silent, None)
    assert (found.clock_uncertainty, found.end_reason) == (0.0, "completed")
    assert (found.ambient_c, found.ambient_uncertainty_c, found.program) == (None, 0.0, None)
    assert (found.wiring, found.content_sha256) == (Wiring(), "")
    current = found.channels["current"]
    usual = Channel("current", "", current.raw, 0.5)
    assert replace(current, raw=b"") == replace(usual, raw=b"")  # type: ignore[arg-type]


@pytest.mark.parametrize(("minor", "known"), [(1, False), (2, True)])
def test_an_older_import_did_not_say_what_was_stated(minor: int, known: bool) -> None:
    def imported(file: h5py.File) -> None:
        file["provenance"].create_dataset("imported_from", data="log.csv")
        file.attrs["content_sha256"] = "x"

    found = changed(imported, minor).channels["terminal_voltage"].undeclared
    assert (found == ()) is known
    mine = changed(lambda f: f.attrs.__setitem__("content_sha256", "x"), minor)
    assert mine.channels["terminal_voltage"].undeclared == ()


def attribute(name: str, value: Any, at: str = "samples/current") -> Callable[[h5py.File], None]:
    def put(file: h5py.File) -> None:
        (file[at] if at else file).attrs[name] = value

    return put


def data(name: str, value: Any, **how: Any) -> Callable[[h5py.File], None]:
    def put(file: h5py.File) -> None:
        said = dict(file[name].attrs)
        del file[name]
        file.create_dataset(name, data=value, **how).attrs.update(said)

    return put


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (attribute("clock_hz", 0.0, ""), "clock_hz must be above 0"),
        (attribute("clock_uncertainty", "x", ""), "clock_uncertainty is not a number"),
        (attribute("ambient_c", np.inf, ""), "ambient_c is not a number"),
        (attribute("format_major", 2, ""), "capture format 2 is not 1"),
        (attribute("scale", 0.0), "current has no scale"),
        (attribute("filter_order", 3), "filter_order is 3"),
        (attribute("filter_order", 1.5), "filter_order is 1.5"),
        (attribute("unit", 3.0), "attribute unit is 3.0"),
        (attribute("noise", "much"), "attribute noise is 'much'"),
        (attribute("noise", NAN), "attribute noise is nan"),
        (attribute("raw_min", np.inf), "attribute raw_min is inf"),
        (attribute("raw_max", -np.inf), "attribute raw_max is -inf"),
        (attribute("sense", "odd"), "sense is 'odd'"),
        (attribute("undeclared", "offset odd"), "undeclared is 'offset odd'"),
        (attribute("undeclared", "offset offset"), "undeclared is 'offset offset'"),
        (attribute("scale", [1.0, 2.0]), "scale has the wrong type"),
        (data("samples/tick", np.array([1, 2, 2])), "tick does not increase"),
        (data("samples/tick", np.array([1.0, 2.0, 3.0])), "holds float64, not integers"),
        (data("samples/current", np.zeros(3, np.complex64)), "holds complex64, not numbers"),
        (data("samples/current", np.zeros(3, np.longdouble)), "not numbers"),
        (data("samples/current", np.zeros((3, 1))), "is not a 1-dimensional dataset"),
        (data("samples/current", np.zeros(4)), "has 4 readings for 3 ticks"),
        (data("program", 3), "program is not text"),
        (data("gaps", np.array([(4, 1, b"")], GAPS)), "gap lies outside"),
        (data("gaps", np.array([(-1, 1, b"")], GAPS)), "gap lies outside"),
        (data("gaps", np.zeros(1, GAPS[:2])), "gaps lacks one of index, samples, r"),
        (data("phases", np.zeros(1, [("index", "i8")])), "phases lacks one of index, tick"),
        (lambda f: f.attrs.__setitem__("format_minor", 1), "its digest is missing"),
    ],
)  # fmt: skip
def test_what_no_capture_says_is_damage(change: Any, says: str) -> None:
    with pytest.raises(DataError, match=rf"^run\.h5: .*{says}"):
        changed(change)


@pytest.mark.slow
def test_what_a_capture_may_say() -> None:
    found = changed(attribute("raw_min", -np.inf)).channels["current"]
    assert found.raw_min == -np.inf
    assert changed(attribute("raw_max", np.inf)).channels["current"].raw_max == np.inf
    assert changed(attribute("filter_order", 1.0)).channels["current"].filter_order == 1
    gap = np.array(
        [(0, 1, b"a"), (3, 2, b"b")], [("index", "i8"), ("samples", "i8"), ("reason", "S9")]
    )
    assert changed(data("gaps", gap)).gaps == (Gap(0, 1, "a"), Gap(3, 2, "b"))
    big = changed(data("samples/current", np.array([1, 2, 3], ">i4"))).channels["current"].raw
    assert big.tolist() == [1, 2, 3]
    assert big.dtype.isnative
    text = changed(lambda f: f["provenance"].create_dataset("mine", data=b"plain")).provenance
    assert text["mine"] == "plain"  # which nobody called JSON


@pytest.mark.parametrize(("size", "good"), [(500, True), (501, False)])
def test_a_text_of_so_many_bytes(size: int, good: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_read, "MAX_TEXT", 500)
    text = b'"' + b"x" * (size - 2) + b'"'
    says = "program version" if good else f"program claims {size} bytes of text: refused"
    with pytest.raises(DataError, match=says):
        changed(
            data("program", np.bytes_(b'{"version": 9}'.ljust(size)) if good else np.bytes_(text))
        )


# -- sizes before data
def test_a_file_s_bytes_are_what_it_may_claim(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        guard = Guard(file, 10)
        assert guard.budget == 11_000
        guard.spend(11_000, "x")
        with pytest.raises(DataError, match="x claims more data than the file can hold"):
            guard.spend(1, "x")
        assert Guard(file, 2**60).budget == store_guard.MAX_DATA
        made = file.create_dataset("x", data=np.zeros(1375))
        Guard(file, 10).readable(made, "x")  # 8 bytes each
        more = file.create_dataset("y", data=np.zeros(1376))
        with pytest.raises(DataError, match="y claims more data"):
            Guard(file, 10).readable(more, "y")


def test_so_many_rows_and_members(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_guard, "CAPTURE", SimpleNamespace(rows=3))
    monkeypatch.setattr(store_guard, "MAX_MEMBERS", 2)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        guard = Guard(file, 1000)
        guard.readable(file.create_dataset("x", data=np.zeros(3)), "x")
        guard.readable(file.create_dataset("y", data=1.0), "y")
        assert guard.members(file) == ["x", "y"]
        with pytest.raises(DataError, match="z claims 4 rows, and a capture may have 3"):
            guard.readable(file.create_dataset("z", data=np.zeros(4)), "z")
        with pytest.raises(DataError, match="/ has 3 entries: not a motorid capture"):
            guard.members(file)


# -- the digest
def digest(path: Path, fill: Callable[[h5py.File], Any]) -> str:
    with h5py.File(path, "w") as file:
        fill(file)
        return content_sha256(file, 10**6)


def test_the_digest_is_of_names_types_shapes_and_values(tmp_path: Path) -> None:
    def table(kind: str, name: str = "b") -> Any:
        return np.array([(1, 2)], [("a", "i4"), (name, kind)])

    fills: list[Callable[[h5py.File], Any]] = [
        lambda f: None,
        lambda f: f.create_group("x"),
        lambda f: f.create_dataset("x", data=np.array([1, 2], "i4")),
        lambda f: f.create_dataset("y", data=np.array([1, 2], "i4")),
        lambda f: f.create_dataset("x", data=np.array([1, 3], "i4")),
        lambda f: f.create_dataset("x", data=np.array([1, 2], "u4")),
        lambda f: f.create_dataset("x", data=np.array([[1, 2]], "i4")),
        lambda f: f.create_dataset("x", data=["1", "2"]),
        lambda f: f.create_dataset("x", data=["12"]),
        lambda f: f.create_dataset("x", data=table("i4")),
        lambda f: f.create_dataset("x", data=table("i8")),
        lambda f: f.create_dataset("x", data=table("i4", "c")),
        lambda f: f.attrs.__setitem__("x", 1.0),
        lambda f: f.attrs.__setitem__("y", 1.0),
        lambda f: f.attrs.__setitem__("x", 2.0),
        lambda f: f.attrs.__setitem__("x", "1"),
        lambda f: f.create_group("x").attrs.__setitem__("content_sha256", "1"),
    ]
    found = [digest(tmp_path / f"{n}.h5", fill) for n, fill in enumerate(fills)]
    assert len(set(found)) == len(fills)


def test_the_digest_is_the_same_however_the_bytes_lie(tmp_path: Path) -> None:
    def put(file: h5py.File, order: str, names: str, **how: Any) -> None:
        for name in names:
            file.create_dataset(name, data=np.arange(300, dtype=f"{order}i4"), **how)
        file.attrs["content_sha256"] = names  # which it does not cover

    one = digest(tmp_path / "1.h5", lambda f: put(f, "<", "ab"))
    other = digest(tmp_path / "2.h5", lambda f: put(f, ">", "ba", compression="gzip"))
    assert one == other


@pytest.mark.parametrize(
    ("fill", "says"),
    [
        (lambda f: f.create_dataset("x", data=np.zeros(2, np.complex64)), "x holds complex64"),
        (lambda f: f.attrs.__setitem__("x", np.zeros(2, np.complex64)), "@x holds complex64"),
        (lambda f: f.attrs.__setitem__("x", h5py.Empty("f8")), "@x has a size that no capture"),
        (lambda f: f.attrs.__setitem__("x", f.create_group("g").ref), "@x holds object"),
        (lambda f: f.__setitem__("x", np.dtype("i4")), "x is neither group nor dataset"),
    ],
)
def test_what_no_capture_holds_has_no_digest(fill: Any, says: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=says):
        digest(tmp_path / "a.h5", fill)


@pytest.mark.parametrize(("count", "good"), [(3, True), (4, False)])
def test_so_many_attributes_and_values(
    count: int, good: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(content_digest, "MAX_ATTRIBUTES", 3)
    monkeypatch.setattr(content_digest, "MAX_VALUES", 3)
    fills: list[Any] = [
        lambda f: [f.attrs.__setitem__(str(n), 1.0) for n in range(count)],
        lambda f: f.attrs.__setitem__("x", np.zeros(count)),
    ]
    for number, fill in enumerate(fills):
        if good:
            digest(tmp_path / f"{number}.h5", fill)
        else:
            with pytest.raises(DataError, match=r"has 4 attributes|a size that no capture has"):
                digest(tmp_path / f"{number}.h5", fill)
