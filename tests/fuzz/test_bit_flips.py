"""One flipped bit is seen: in every kind of file, by the readers and by the commands."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from motorid.cli.main import run as command
from motorid.errors import EXIT_DATA
from motorid.workflow.verify import DAMAGED
from tests.fuzz import bit_flips
from tests.fuzz.bit_flips import OTHER, SAID, SAME, SILENT, WholeFile

FLIPS = {"capture": 30, "journal": 150, "estimate": 100, "verdict": 100}
EVERY_KIND = [
    pytest.param(
        kind,
        marks=pytest.mark.skipif(
            kind == "capture" and sys.platform != "linux",
            reason="only Linux limits a process's memory and time",
        ),
    )
    for kind in FLIPS
]


@pytest.mark.slow
@pytest.mark.parametrize("kind", EVERY_KIND)
def test_a_flipped_bit_leaves_the_data_or_is_said(kind: str) -> None:
    counts, broken = bit_flips.run(FLIPS[kind], seed=1, only=kind)
    assert broken == []
    assert counts[kind][SAID] > FLIPS[kind] // 4  # a tool that sees nothing would pass


def test_the_tool_sees_other_data_and_a_refusal_without_the_word() -> None:
    from motorid.errors import DataError

    def refuse(data: bytes) -> None:
        raise DataError("no")

    blind = WholeFile(b"abc", lambda data: data)
    assert bit_flips.outcome(blind, b"abb", b"abc") == OTHER
    assert bit_flips.outcome(blind, b"abc", b"abc") == SAME
    assert bit_flips.outcome(WholeFile(b"abc", refuse), b"abb", b"abc") == SILENT


@pytest.mark.slow
@pytest.mark.parametrize("kind", FLIPS)
def test_verify_says_of_a_changed_file_what_the_readers_say(kind: str, tmp_path: Path) -> None:
    whole = bit_flips.kinds()[kind]
    assert bit_flips.through_the_command(kind, whole.data, tmp_path) == "sound"
    words = {"capture": b"terminal_voltage", "journal": b"zero_samples"}
    changed = bytearray(whole.data)
    changed[changed.rindex(words.get(kind, b'"value"')) + 1] ^= 4
    assert bit_flips.through_the_command(kind, bytes(changed), tmp_path) == DAMAGED


@pytest.mark.slow
def test_a_damaged_capture_is_not_fitted(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Each byte of the current's readings is under a checksum."""
    import h5py

    path = tmp_path / "run.h5"
    data = bytearray(bit_flips.kinds()["capture"].data)
    path.write_bytes(data)
    with h5py.File(path) as file:
        chunk = file["samples/current"].id.get_chunk_info(0)
    data[chunk.byte_offset + chunk.size // 2] ^= 1
    path.write_bytes(data)
    assert command(["fit", str(path)]) == EXIT_DATA
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert "/samples/current is damaged" in said
    assert command(["verify", "--json", str(path)]) == EXIT_DATA
    found = json.loads(capfd.readouterr().out)
    assert found["counts"] == {"sound": 0, "carries no digest": 0, "cut short": 0, "damaged": 1}
    assert "/samples/current" in found["files"][0]["where"]
