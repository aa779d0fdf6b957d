"""Signed limits: signatures against openssl's, stations that refuse, the history's check."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from motorid.cli.main import run
from motorid.errors import UsageError
from motorid.quality import signed
from motorid.quality.history import ResultRecord, open_history
from motorid.quality.judge import not_measured
from motorid.quality.product import load_product
from motorid.quality.signed import Trusted, read_trusted

LIMITS = Path(__file__).parents[2] / "products" / "sim-disc.toml"


def new_key(path: Path) -> Path:
    from cryptography.hazmat.primitives import serialization as s
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

    key = Ed25519PrivateKey.generate()
    form, lock = s.PrivateFormat.PKCS8, s.NoEncryption()
    path.write_bytes(key.private_bytes(s.Encoding.PEM, form, lock))
    return path


@pytest.fixture
def limits(tmp_path: Path) -> Path:
    return Path(shutil.copy(LIMITS, tmp_path / "m17.toml"))


@pytest.fixture
def key(tmp_path: Path) -> Path:
    return new_key(tmp_path / "limits.pem")


@pytest.fixture
def trusted(key: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    assert run(["product", "public", str(key), "--signer", "limits-2026"]) == 0
    path = tmp_path / "trusted.toml"
    path.write_text(capsys.readouterr().out)
    return path


def sign(limits: Path, key: Path, *more: str) -> int:
    return run(
        ["product", "sign", str(limits), "--key", str(key), "--signer", "limits-2026", *more]
    )


def test_a_signature_holds_until_the_limits_change(limits: Path, key: Path, trusted: Path) -> None:
    verify = ["product", "verify", str(limits), "--trusted", str(trusted)]
    assert run(verify) == 4  # nobody signed
    assert sign(limits, key) == 0
    assert run(verify) == 0
    assert sign(limits, key) == 2  # it is there
    limits.write_text(limits.read_text().replace("high = 2.8", "high = 2.9"))
    assert run(verify) == 4
    assert sign(limits, key, "--force") == 0
    assert run(verify) == 0


def test_openssl_agrees(limits: Path, key: Path, tmp_path: Path) -> None:
    """Another program checks the signature over what the page says is signed."""
    sign(limits, key)
    made = json.loads(signed.place(limits).read_text())
    proof = base64.b64decode(made.pop("signature"))
    (tmp_path / "said").write_bytes(json.dumps(made, sort_keys=True).encode())
    (tmp_path / "proof").write_bytes(proof)
    words = ["openssl", "pkeyutl", "-verify", "-rawin", "-inkey", str(key)]
    words += ["-in", str(tmp_path / "said"), "-sigfile", str(tmp_path / "proof")]
    done = subprocess.run(words, capture_output=True, text=True)
    assert "Verified Successfully" in done.stdout, done.stderr


Change = Callable[[dict[str, Any]], None]


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda said: said.update(signer="another"), "the key another that signed them is not"),
        (lambda said: said.update(time="2030-01-01T00:00:00+00:00"), "not of the trusted key"),
        (lambda said: said.update(sha256="0" * 64), "is for other limits"),
        (lambda said: said.update(signature="AAAA"), "not of the trusted key"),
        (lambda said: said.update(signature="?"), "damaged"),
        (lambda said: said.pop("signer"), "damaged"),
    ],
)
def test_what_is_changed_is_seen(
    change: Change, why: str, limits: Path, key: Path, trusted: Path
) -> None:
    product = load_product(limits)
    said = json.loads(signed.sign(product.digest, "limits-2026", key.read_bytes()).text)
    change(said)
    assert why in read_trusted(trusted).problem(json.dumps(said), product.digest)


def test_another_key_of_the_same_name_is_foreign(
    limits: Path, trusted: Path, tmp_path: Path
) -> None:
    sign(limits, new_key(tmp_path / "other.pem"))
    product = load_product(limits)
    found = read_trusted(trusted).problem(product.signature, product.digest)
    assert "not of the trusted key limits-2026" in found


@pytest.mark.slow
def test_the_history_names_results_of_unsigned_and_foreign_limits(
    limits: Path, key: Path, trusted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    book = str(tmp_path / "line.db")
    plain = load_product(limits)
    sign(limits, key)
    good = load_product(limits)
    sign(limits, new_key(tmp_path / "other.pem"), "--force")
    foreign = load_product(limits)
    with open_history(book) as history:
        for number, product in enumerate((plain, good, foreign)):
            verdict = not_measured(product, f"D{number}", "no rig")
            record = ResultRecord(
                "check", verdict.serial, (), product=product.name, station="line-1",
                versions=dict(verdict.versions), limits=product.text,
            )  # fmt: skip
            assert history.add(record)
    capsys.readouterr()
    assert run(["history", "verify", book]) == 0  # as ever, where nobody asks
    assert run(["history", "verify", book, "--trusted", str(trusted)]) == 4
    lines = [one for one in capsys.readouterr().out.splitlines() if one.startswith("UNSIGNED")]
    assert len(lines) == 2
    assert "result 1" in lines[0]
    assert "nobody signed them" in lines[0]
    assert "result 3" in lines[1]
    assert "not of the trusted key" in lines[1]


def test_a_station_refuses_limits_that_do_not_count(
    limits: Path, key: Path, trusted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    call = ["station", "--product", str(limits), "--rig", "sim-line", "--trusted", str(trusted)]
    call += ["--listen", "0.0.0.0:1", "-o", str(tmp_path / "shift")]
    assert run(call) == 2
    assert "nobody signed them" in " ".join(capsys.readouterr().err.split())
    sign(limits, key)
    capsys.readouterr()
    assert run(call) == 2  # and now for the next reason
    assert "can be reached from other computers" in " ".join(capsys.readouterr().err.split())


def test_keys_and_files_that_are_none(limits: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no private key in PEM"):
        signed.sign("0" * 64, "x", b"x")
    signed.place(limits).write_text("{}")
    with pytest.raises(UsageError, match="product sign makes one"):
        load_product(limits)
    path = tmp_path / "keys.toml"
    for text, why in (("", "names none"), ("[keyz]", "nearest"), ('[keys]\nx = "AA"', "no public")):
        path.write_text(text)
        with pytest.raises(Exception, match=why):
            read_trusted(path)
    assert "nobody" in Trusted({}).problem("", "0" * 64)
