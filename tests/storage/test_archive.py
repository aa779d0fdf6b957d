"""Packs: opened by other programs, read one by one, sealed, and deleted by a rule."""

from __future__ import annotations

import json
import shutil
import zipfile
from datetime import UTC, date, datetime
from pathlib import Path

import pytest

from motorid import json_seal, json_text
from motorid.cli.main import run
from motorid.errors import DataError
from motorid.quality.history import CaptureRecord, ResultRecord, open_history
from motorid.storage import captures, object_store, pack, pack_write
from motorid.storage.pack_write import Source
from motorid.storage.place import Member, Place, Url, place
from motorid.workflow.archive import Packed, pack_captures
from motorid.workflow.many import fit_many, table
from tests.storage.stores import Store, folder_of

pytestmark = pytest.mark.slow


@pytest.fixture(scope="session")
def shift(motors: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two inspections of station s 1 with their verdicts, and one that is torn."""
    folder = tmp_path_factory.mktemp("shift")
    for number in range(2):
        one = folder / f"D{number}_20261125T06000{number}"
        one.mkdir()
        shutil.copy(motors / f"m{number}.h5", one / "capture.h5")
        verdict = json_seal.sealed({"schema": "motorid-verdict-1", "station": "s 1"})
        (one / "verdict.json").write_text(json_text.dumps(verdict))
    (folder / "D2_20261125T060002").mkdir()
    shutil.copy(motors / "torn.h5", folder / "D2_20261125T060002" / "capture.h5")
    return folder


def packed(places: list[Place], archive: Path | Url, **options: object) -> list[Packed]:
    return list(pack_captures(places, archive, **options))  # type: ignore[arg-type]


def day_of(path: Path) -> str:
    return str(captures.load(path).provenance["created"])[:10]


def test_a_pack_is_a_zip_that_its_index_seals(shift: Path, tmp_path: Path) -> None:
    made, torn = sorted(packed([shift], tmp_path), key=lambda one: bool(one.failure))
    assert "torn" in str(torn.failure) or "damaged" in torn.failure
    day = day_of(shift / "D0_20261125T060000" / "capture.h5")
    assert (made.place, made.count) == (tmp_path / "s 1" / f"{day}.zip", 2)
    with zipfile.ZipFile(str(made.place)) as other:  # another program
        assert other.testzip() is None
        assert sorted(other.namelist()) == sorted(
            folder_of(shift) - {"D2_20261125T060002/capture.h5"}
        )
        for name in other.namelist():
            assert other.read(name) == (shift / name).read_bytes()
    inner = "D1_20261125T060001/capture.h5"
    found = captures.load(Member(made.place, inner))  # type: ignore[arg-type]
    assert found.sha256 == captures.load(shift / inner).sha256
    assert found.path == f"{made.place}#{inner}"
    assert [one.count for one in packed([shift], tmp_path)] == [0]  # the torn one alone
    assert pack.damage(made.place) == ""  # type: ignore[arg-type]


def test_a_later_capture_of_a_day_makes_a_further_pack(motors: Path, tmp_path: Path) -> None:
    first = packed([motors / "m0.h5"], tmp_path, station="a/b")
    later = packed([motors], tmp_path, station="a/b", most_bytes=1)
    names = [str(one.place) for one in (*first, *later) if not one.failure]
    day = day_of(motors / "m0.h5")
    assert names == [f"{tmp_path}/a%2Fb/{day}{n}.zip" for n in ("", ".2", ".3")]
    with pytest.raises(DataError, match=r"holds no .m9\.h5."):
        captures.load(place(f"{names[0]}#m9.h5"))
    (unnamed,) = packed([motors / "m1.h5"], tmp_path / "other")
    assert "say it by --station" in unnamed.failure


def test_fits_from_a_pack_are_those_of_the_files(here: Store, motors: Path, tmp_path: Path) -> None:
    """In an object store, of which the ranges of the captures alone are read."""
    archive = Url(here.bucket("packs"))
    good = [motors / f"m{n}.h5" for n in range(3)]
    (made,) = packed([*good], archive, station="s1")
    asked: list[tuple[str, int | None]] = []
    whole = object_store.read

    def watched(url: Url, start: int | None = None, end: int | None = None) -> bytes:
        asked.append((url.suffix, start))
        return whole(url, start, end)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(object_store, "read", watched)
        far = fit_many(captures.captures_in([archive]), tmp_path / "far", model="six")
    assert [suffix for suffix, start in asked if start is None] in ([], [".json"])
    near = fit_many(good, tmp_path / "near", model="six")
    assert table(far).replace(f"{made.place}#", "") == table(near).replace(f"{motors}/", "")


@pytest.mark.parametrize("at", [0.02, 0.5, 0.9999])
def test_damage_is_seen(at: float, motors: Path, tmp_path: Path) -> None:
    (made,) = packed([motors / "m0.h5"], tmp_path, station="s1")
    path = Path(str(made.place))
    data = bytearray(path.read_bytes())
    data[int(at * len(data))] ^= 1
    path.write_bytes(data)
    assert run(["verify", str(path)]) == 4
    index = pack.index_place(path)
    assert isinstance(index, Path)
    index.write_text(index.read_text().replace('"serial": "D0"', '"serial": "x"', 1))
    with pytest.raises(DataError, match="not what its digest says"):
        pack.read_index(path)


def test_a_pack_without_an_index_is_none_yet_and_is_made_anew(motors: Path, tmp_path: Path) -> None:
    """As a process leaves it that was killed between the two."""
    (made,) = packed([motors / "m0.h5"], tmp_path, station="s1")
    path = Path(str(made.place))
    pack.index_of.cache_clear()
    Path(str(pack.index_place(path))).unlink()
    path.write_bytes(path.read_bytes()[:1000])
    assert packed([motors / "m0.h5"], tmp_path, station="s1") == [made]
    assert pack.damage(path) == ""


def test_a_history_finds_captures_that_went_into_packs(
    motors: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = tmp_path / "kept"
    kept.mkdir()
    shutil.copy(motors / "m0.h5", kept / "m0.h5")
    book, product = str(tmp_path / "line.db"), ["--product", "sim-disc"]
    assert run(["history", "add", book, str(kept / "m0.h5"), *product]) == 0
    archive = str(tmp_path / "packs")
    assert run(["archive", "pack", archive, str(kept), "--station", "s1"]) == 0
    (kept / "m0.h5").unlink()
    assert run(["history", "rejudge", book, *product]) == 4
    assert run(["history", "rejudge", book, *product, "--captures", archive]) == 0
    assert "1 judged" in capsys.readouterr().err
    sha256 = captures.sha256_of(motors / "m0.h5")
    assert run(["archive", "find", archive, sha256[:12]]) == 0
    name = capsys.readouterr().out.split("  ")[0]
    assert captures.load(place(name)).sha256 == sha256
    assert run(["archive", "find", archive, "nobody"]) == 4
    assert run(["verify", archive]) == 0
    assert "sound" in capsys.readouterr().out


def old_pack(archive: Path, day: str, sha: Path) -> Path:
    target = archive / "s1" / f"{day}.zip"
    pack_write.write(target, [Source(sha, "m.h5", "D1")], "s1", day)
    return target


def test_old_packs_go_whole_and_never_silently(
    motors: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    archive, book = tmp_path / "packs", tmp_path / "line.db"
    cited = old_pack(archive, "2020-01-01", motors / "m0.h5")
    bare = old_pack(archive, "2020-01-02", motors / "m1.h5")
    new = old_pack(archive, datetime.now(UTC).date().isoformat(), motors / "m2.h5")
    one = CaptureRecord(captures.sha256_of(motors / "m0.h5"), "m0.h5")
    with open_history(book) as history:
        for number in range(2):
            history.add(ResultRecord("check", f"D{number}", (), (one,)))
    words = ["archive", "delete", str(archive), "--keep", "30"]
    assert run(words) == 2
    assert run([*words, "--history", str(book), "--dry-run"]) == 0
    capsys.readouterr()
    assert run([*words, "--history", str(book)]) == 2
    assert "2 results of the history cite captures in 1 of these 2 packs" in capsys.readouterr().err
    assert cited.exists()
    assert bare.exists()
    assert run([*words, "--history", str(book), "--cited", "--by", "A. Volta"]) == 0
    assert [path.name for path in archive.rglob("*.zip")] == [new.name]
    assert len(list(archive.rglob("*.json"))) == 1
    with open_history(book) as history:
        said = [
            (one["action"], one["who"], one["subject"], one["reason"]) for one in history.trail()
        ]
        assert history.count() == 2
        assert history.verify().problems == ()
    deleted = ("delete captures", "A. Volta")
    assert sorted(said) == [
        (*deleted, str(cited), "1 files; 2 results cite them"),
        (*deleted, str(bare), "1 files; 0 results cite them"),
    ]
    assert date.fromisoformat(new.stem)
    assert json.loads(new.with_suffix(".index.json").read_text())["station"] == "s1"
