"""Captures in an object store: put once, read back, checked, and fitted as from a folder."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import pytest
from s3fs import S3FileSystem

from motorid.cli.main import run
from motorid.errors import DataError, UsageError
from motorid.quality.history import open_history
from motorid.storage import cache, captures, object_store
from motorid.storage.place import Url
from motorid.workflow.many import fit_many, table
from tests.storage.stores import Store

pytestmark = pytest.mark.slow
COPIES = "copies"


@pytest.fixture(scope="session")
def kept(store: Store, motors: Path) -> Url:
    """The captures in a bucket of their own, put there by another client."""
    store.bucket(COPIES)
    for path in motors.iterdir():
        store.put(COPIES, f"line/{path.name}", path.read_bytes())
    return Url(f"s3://{COPIES}/line")


def test_a_file_is_put_once_and_read_back(here: Store, motors: Path) -> None:
    url = Url(here.bucket("once")) / "a/m0.h5"
    sha256 = object_store.put(motors / "m0.h5", url)
    assert hashlib.sha256(here.stored("once", "a/m0.h5")).hexdigest() == sha256
    assert object_store.put(motors / "m0.h5", url) == sha256  # again, as after a crash
    with pytest.raises(UsageError, match="exists already, with another content"):
        object_store.put(motors / "m1.h5", url)
    assert here.stored("once", "a/m0.h5") == (motors / "m0.h5").read_bytes()
    assert object_store.read(url, 1, 4) == b"HDF"
    with pytest.raises(DataError, match="is not there"):
        object_store.read(url.parent / "other.h5")


def test_fits_are_those_of_the_folder_to_the_last_digit(
    here: Store, kept: Url, motors: Path, tmp_path: Path
) -> None:
    far = fit_many(captures.captures_in([kept]), tmp_path / "far", model="six")
    near = fit_many(captures.captures_in([motors]), tmp_path / "near", model="six")
    assert [fit.path for fit in far[:3]] == [f"{kept}/m{n}.h5" for n in range(3)]
    assert table(far).replace(str(kept), "HERE") == table(near).replace(str(motors), "HERE")
    assert [bool(fit.failure) for fit in far] == [False, False, False, True]
    secret = "a-secret-of-the-test"
    written = [one for one in tmp_path.rglob("*") if one.is_file()]
    assert written
    assert not [one for one in written if secret.encode() in one.read_bytes()]


def test_a_copy_that_was_damaged_is_fetched_anew(here: Store, kept: Url, motors: Path) -> None:
    capture = captures.load(kept / "m0.h5")
    assert capture.path == f"{kept}/m0.h5"
    copy = cache.kept(capture.sha256)
    assert copy is not None
    copy.write_bytes(b"another")
    assert cache.kept(capture.sha256) is None
    assert captures.load(kept / "m0.h5", capture.sha256).sha256 == capture.sha256
    here.put(COPIES, "other/changed.h5", (motors / "m0.h5").read_bytes() + b"more")
    with pytest.raises(DataError, match="has other bytes"):
        captures.load(kept.parent / "other/changed.h5", "0" * 64)


def test_the_cache_stays_within_its_size(
    here: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(cache.MOST, "1")
    names = [cache.keep(bytes([n]) * 400_000)[0] for n in range(4)]
    for age, path in enumerate(reversed(names)):
        os.utime(path, (1e9 - age, 1e9 - age))
    cache.make_room(names[3])
    assert {path.name for path in cache.folder().iterdir()} == {n.name for n in names[2:]}
    monkeypatch.setenv(cache.MOST, "plenty")
    with pytest.raises(UsageError, match="MOTORID_CACHE_MB"):
        cache.make_room(names[3])


def test_the_commands_take_urls(
    here: Store, kept: Url, motors: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """fit, check, history add, trace and rejudge; one capture, and a folder."""
    place = str(tmp_path / "line.db")
    one = f"{kept}/m1.h5"
    assert run(["fit", one, "--model", "six", "--json"]) in (0, 4)
    assert f'"path": "{one}"' in capsys.readouterr().out
    product = ["--product", "sim-disc"]
    assert run(["check", *product, "--capture", one, "--history", place]) in (1, 4)
    assert run(["history", "add", place, str(kept), *product]) == 0
    said = capsys.readouterr()
    assert "torn.h5" in said.out
    assert run(["history", "trace", place, one]) == 0
    assert one in capsys.readouterr().out
    with open_history(place) as history:
        assert {row.path for row in history.captures()} == {f"{kept}/m{n}.h5" for n in range(3)}
    assert run(["history", "rejudge", place, *product]) == 0
    assert "3 judged, 0 changed, 0 failed" in capsys.readouterr().err


def test_a_run_goes_into_the_store_and_leaves_the_spool(
    here: Store, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bucket = here.bucket("runs")
    words = ["capture", "--rig", "sim", "--speed", "max", "-o", f"{bucket}/m.h5"]
    assert run([*words, "--repeat", "2"]) == 0
    assert f"wrote {bucket}/m-2.h5" in capsys.readouterr().err
    assert here.stored("runs", "m-1.h5")[1:4] == b"HDF"
    assert not [one for one in (tmp_path / "spool").rglob("*") if one.is_file()]
    assert run([*words, "--repeat", "2"]) == 2  # before anything moves
    assert "exists already" in capsys.readouterr().err


def test_a_store_that_is_away_is_one_sentence_and_the_capture_is_kept(
    here: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")
    S3FileSystem.clear_instance_cache()
    assert run(["fit", "s3://away/m0.h5"]) == 4
    said = capsys.readouterr().err
    assert "s3://away/m0.h5" in said
    assert "Traceback" not in said
    assert run(["capture", "--rig", "sim", "--speed", "max", "-o", "s3://away/m.h5"]) == 4
    assert "the capture is safe in" in capsys.readouterr().err
    (left,) = (tmp_path / "spool").rglob("*.h5")
    assert captures.load(left).end_reason == "completed"
