"""What is a signature of limits, who is trusted, and each sentence of refusal."""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from pathlib import Path

import pytest
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec, ed25519

from motorid.errors import DataError, UsageError
from motorid.quality import signed
from motorid.quality.signed import Signature, Trusted, read_trusted

SHA = "ab" * 32


def pem(key: ed25519.Ed25519PrivateKey | ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )


KEY, OTHER = (pem(ed25519.Ed25519PrivateKey.from_private_bytes(bytes([k]) * 32)) for k in (1, 2))


def raw(key: bytes) -> bytes:
    return base64.b64decode(signed.public(key))


def test_a_signature_is_of_all_that_it_says() -> None:
    one = signed.sign(SHA, "kim", KEY)
    assert (one.signer, one.sha256) == ("kim", SHA)
    assert json.loads(one.said) == {
        "schema": "motorid-signature-1", "signer": "kim", "sha256": SHA, "time": one.time,
    }  # fmt: skip
    public = ed25519.Ed25519PublicKey.from_public_bytes(raw(KEY))
    public.verify(base64.b64decode(one.signature), one.said)  # raises where it is not
    assert signed.parse(one.text) == one
    assert one.time.endswith("+00:00")
    assert len(one.time) == len("2026-11-20T06:30:15+00:00")


def test_who_is_trusted() -> None:
    one = signed.sign(SHA, "kim", KEY)
    trusted = Trusted({"kim": raw(KEY), "lee": raw(OTHER)})
    assert trusted.problem(one.text, SHA) == ""
    assert trusted.problem(one.text, SHA) == ""  # and so it stays
    for text, sha256, said in (
        ("", SHA, "nobody signed them"),
        ("{", SHA, "their signature is damaged"),
        (replace(one, signature="!").text, SHA, "their signature is damaged"),
        (one.text, "cd" * 32, "the signature of kim is for other limits: sign them anew"),
        (replace(one, signer="pat").text, SHA, "the key pat that signed them is not trusted"),
        (replace(one, signer="lee").text, SHA, "their signature is not of the trusted key lee"),
        (replace(one, time="x").text, SHA, "their signature is not of the trusted key kim"),
    ):
        assert trusted.problem(text, sha256) == said


@pytest.mark.parametrize(
    "change",
    [{"schema": "other"}, {"more": "x"}, {"signer": 3}, {"time": None}, {"signature": []}],
)
def test_texts_that_are_no_signature(change: dict[str, object]) -> None:
    whole = json.loads(Signature("kim", "now", SHA, "AA==").text)
    assert signed.parse(json.dumps(whole)).signer == "kim"
    with pytest.raises(ValueError, match="it is no signature"):
        signed.parse(json.dumps(whole | change))
    for text in ("[]", '"x"', json.dumps({k: v for k, v in whole.items() if k != "time"})):
        with pytest.raises(ValueError, match="it is no signature"):
            signed.parse(text)
    with pytest.raises(ValueError, match="it is not JSON"):
        signed.parse("{")


@pytest.mark.parametrize(("name", "good"), [("k" * 200, True), ("k" * 201, False), ("", False),
                                            ("a\tb", False)])  # fmt: skip
def test_names_of_keys(name: str, good: bool) -> None:
    if good:
        assert signed.sign(SHA, name, KEY).signer == name
    else:
        with pytest.raises(UsageError, match="at most 200 printable characters"):
            signed.sign(SHA, name, KEY)


def test_keys_that_are_none() -> None:
    with pytest.raises(UsageError, match="no private key in PEM"):
        signed.public(b"nothing")
    with pytest.raises(UsageError, match="none of Ed25519"):
        signed.public(pem(ec.generate_private_key(ec.SECP256R1())))


def test_the_signature_beside_a_product(tmp_path: Path) -> None:
    product = tmp_path / "pump.toml"
    assert signed.place(product) == tmp_path / "pump.toml.sig"
    assert signed.beside(product) == ""
    one = signed.sign(SHA, "kim", KEY)
    signed.place(product).write_text(json.dumps(json.loads(one.text), indent=1), encoding="utf-8")
    assert signed.beside(product) == one.text
    signed.place(product).write_bytes(b"\xff")
    with pytest.raises(UsageError, match=r"\.sig: it is not JSON .*product sign makes one"):
        signed.beside(product)


def test_a_file_of_trusted_keys(tmp_path: Path) -> None:
    path = tmp_path / "keys.toml"
    path.write_text(f'[keys]\nkim = "{signed.public(KEY)}"\n', encoding="utf-8")
    assert read_trusted(path).keys == {"kim": raw(KEY)}
    short = base64.b64encode(b"x" * 31).decode()
    for text, error, said in (
        ("", UsageError, "names none"), ("[keys]\n", UsageError, "names none"),
        ("keys = 3\n", UsageError, "names none"), ("[kyes]\n", UsageError, "unknown key kyes"),
        (f'[keys]\nkim = "{short}"\n', DataError, r"keys\.kim is no public key of Ed25519"),
        ('[keys]\nkim = "!!"\n', DataError, r"keys\.kim is no public key of Ed25519"),
        ("[keys]\nkim = 3\n", DataError, r"keys\.kim is no public key of Ed25519"),
    ):  # fmt: skip
        path.write_text(text, encoding="utf-8")
        with pytest.raises(error, match=said):
            read_trusted(path)
