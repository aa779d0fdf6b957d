"""What a person may name: paths, URLs, files of packs; and what is refused in one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from motorid.errors import UsageError
from motorid.storage.place import Member, Url, place


def test_each_form_is_what_it_says(tmp_path: Path) -> None:
    assert place("captures/run.h5") == Path("captures/run.h5")
    assert place("s3://plant/line 1/run.h5") == Url("s3://plant/line 1/run.h5")
    found = place("s3://plant/packs/day.zip#M1/capture.h5")
    assert found == Member(Url("s3://plant/packs/day.zip"), "M1/capture.h5")
    assert (found.name, found.stem) == ("capture.h5", "capture")
    assert place("day.zip#a.h5") == Member(Path("day.zip"), "a.h5")
    odd = tmp_path / "day.zip#a.h5"
    odd.write_bytes(b"")
    assert place(str(odd)) == odd  # a file of that very name


def test_a_url_has_the_parts_of_a_path() -> None:
    url = Url("s3://plant/line-1/run.2.h5")
    assert (url.name, url.stem, url.suffix) == ("run.2.h5", "run.2", ".h5")
    assert url.parent / "other.h5" == Url("s3://plant/line-1/other.h5")
    assert Url("s3://plant/") / "run.h5" == Url("s3://plant/run.h5")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("http://example.com/run.h5", "in an object store"),
        ("s3://AKIA:secret@plant/run.h5", "belong into the environment"),
        ("s3://plant:9000/run.h5", "belong into the environment"),
        ("s3:///run.h5", "write s3://BUCKET/NAME"),
        ("s3://plant/\x1b[31mrun.h5", "write s3://BUCKET/NAME"),
    ],
)
def test_what_is_no_place_is_refused_and_shows_no_secret(text: str, said: str) -> None:
    with pytest.raises(UsageError, match=said) as refused:
        place(text)
    assert "secret" not in str(refused.value)
    assert str(refused.value).isprintable()
