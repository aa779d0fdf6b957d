"""``motorid verify``: a line a file, whatever lies in the folder."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from motorid.acquire.journal import Kind, read_journal
from motorid.acquire.journal_check import Wholeness, check_journal, state_of
from motorid.acquire.journal_writer import JournalWriter
from motorid.cli.main import run
from motorid.workflow.verify import verify
from tests.fuzz.bit_flips import kinds

CORPUS = Path(__file__).resolve().parents[1] / "corpus" / "format_1_0"


@pytest.fixture
def journal(tmp_path: Path) -> Path:
    """A journal that was written and closed."""
    path = tmp_path / "run.h5.journal"
    writer = JournalWriter(path, {"rig_name": "sim"})
    for n in range(20):
        writer.append(Kind.RECEIVED, 0.1 * n, bytes([n]) * 50)
    writer.close()
    return path


@pytest.mark.slow
def test_a_folder_of_every_kind(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(CORPUS, tmp_path / "old")
    (tmp_path / "new").mkdir()
    for kind, whole in kinds().items():
        name = {"capture": "run.h5", "journal": "run.h5.journal"}.get(kind, f"{kind}.json")
        (tmp_path / "new" / name).write_bytes(whole.data)
    (tmp_path / "other.json").write_text('{"schema": "else"}')
    (tmp_path / "torn.json").write_text("{")
    (tmp_path / "notes.txt").write_text("nothing of motorid's")
    assert run(["verify", str(tmp_path)]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert [line[:17].strip() for line in lines] == ["sound"] * 4 + ["carries no digest"] * 5
    assert all(line.count(str(tmp_path)) == 1 for line in lines)


def test_damage_ends_with_4_and_the_rest_is_still_said(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    (tmp_path / "estimate.json").write_text("{")
    shutil.copy(CORPUS / "verdict.json", tmp_path)
    assert run(["verify", str(tmp_path)]) == 4
    lines = capfd.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["damaged", "damaged", "carries"]


@pytest.mark.parametrize(("name", "code"), [("absent.h5", 2), ("notes.txt", 4), ("empty", 4)])
def test_what_is_not_there_or_not_motorid_s_is_one_sentence(
    name: str,
    code: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "notes.txt").write_text("a,b\n1,2\n")
    (tmp_path / "empty").mkdir()
    assert run(["verify", name]) == code
    said = capfd.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert name in said.err


def test_a_name_with_a_line_end_is_one_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(CORPUS / "verdict.json", tmp_path / "a\nb.json")
    assert run(["verify", str(tmp_path)]) == 0
    assert len(capfd.readouterr().out.splitlines()) == 1


def test_a_history_whose_text_changed_is_damaged(tmp_path: Path) -> None:
    data = (CORPUS / "line.db").read_bytes()
    path = tmp_path / "line.db"
    path.write_bytes(data.replace(b"nameplate", b"namedlate", 1))
    (found,) = verify([path])
    assert (found.state, found.kind) == ("damaged", "history")
    assert "digest" in found.where


def test_a_closed_journal_is_sound_and_reads_as_before(journal: Path) -> None:
    assert check_journal(journal).whole is Wholeness.SOUND
    found = read_journal(journal)
    assert (len(found.records), found.torn) == (20, 0)


def test_a_journal_cut_anywhere_is_cut_and_not_damaged(journal: Path) -> None:
    data = journal.read_bytes()
    for end in range(len(data)):
        whole = state_of(data[:end]).whole
        assert whole in (Wholeness.CUT, Wholeness.OPEN), end
    assert state_of(data[:700] + bytes(len(data) - 700)).whole is Wholeness.CUT


def test_a_journal_with_a_byte_changed_anywhere_is_damaged(journal: Path) -> None:
    data = journal.read_bytes()
    for at in range(len(data)):
        changed = bytearray(data)
        changed[at] ^= 0x20
        assert state_of(bytes(changed)).whole is Wholeness.DAMAGED, at


def test_records_taken_out_of_a_closed_journal_are_missed(journal: Path) -> None:
    data = journal.read_bytes()
    size = 13 + 50 + 4
    begin = data.index(bytes([5]) * 50) - 13
    assert state_of(data[:begin] + data[begin + size :]).whole is Wholeness.DAMAGED


@pytest.mark.slow
def test_recover_says_that_a_journal_is_damaged(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run.h5.journal"
    data = bytearray((CORPUS / "cut.h5.journal").read_bytes())
    data[len(data) * 3 // 4] ^= 1
    path.write_bytes(data)
    assert run(["recover", str(path)]) == 0
    assert "the journal is damaged (from byte" in capfd.readouterr().err


def test_findings_as_json(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["verify", "--json", str(CORPUS / "run.h5")]) == 0
    found = json.loads(capfd.readouterr().out)
    assert found["schema"] == "motorid-verify-1"
    assert found["counts"]["carries no digest"] == 1
    assert found["files"][0]["kind"] == "capture"
