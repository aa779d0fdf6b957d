"""Limits that a named key has signed (Ed25519), and whether that key is trusted.

    signature = Ed25519(key, canonical JSON of schema, signer, time and the product file's SHA-256)

It stands beside the product file, goes into each verdict, and from there into the history's seals.
"""

from __future__ import annotations

import base64
import binascii
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid import json_text
from motorid.errors import DataError, UsageError
from motorid.limits import JSON
from motorid.reading import read_file
from motorid.toml_file import read_text, tables_of, unknown

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

SCHEMA = "motorid-signature-1"
ENDING = ".sig"  # behind the name of the product file
LONGEST_NAME = 200
NEEDED = "signed limits need cryptography: pip install 'motorid[plant]'"


@dataclass(frozen=True)
class Signature:
    """Who signed the product file of that SHA-256, when, and the proof."""

    signer: str
    time: str
    sha256: str
    signature: str = ""  # base64

    @property
    def said(self) -> bytes:
        """What is signed."""
        document = {**asdict(self), "schema": SCHEMA}
        del document["signature"]
        return json_text.canonical(document).encode()

    @property
    def text(self) -> str:
        """One line of JSON, as verdicts cite it."""
        return json_text.canonical({**asdict(self), "schema": SCHEMA})


def parse(text: str) -> Signature:
    """The signature that a text is. Raises ValueError."""
    try:
        said = json_text.loads(text)
    except json_text.JsonError as error:
        raise ValueError(f"it is not JSON ({error})") from None
    names = {"schema", "signer", "time", "sha256", "signature"}
    whole = isinstance(said, dict) and said.keys() == names and said["schema"] == SCHEMA
    if not whole or not all(isinstance(one, str) for one in said.values()):
        raise ValueError("it is no signature")
    return Signature(said["signer"], said["time"], said["sha256"], said["signature"])


def place(product: Path) -> Path:
    """Where the signature of a product file is."""
    return product.with_name(product.name + ENDING)


def beside(product: Path) -> str:
    """The signature beside a product file as verdicts cite it; "" where there is none.

    Raises UsageError where the file there is none.
    """
    path = place(product)
    if not path.exists():
        return ""
    text = read_file(path, UsageError, JSON.file, "a signature").decode("utf-8", "replace")
    try:
        return parse(text).text
    except ValueError as error:
        raise UsageError(f"{path}: {error}: motorid product sign makes one") from None


def sign(sha256: str, signer: str, key: bytes) -> Signature:
    """Signs a product file's digest with a private key in PEM. Raises UsageError."""
    if not signer or len(signer) > LONGEST_NAME or not signer.isprintable():
        raise UsageError(f"name the key by at most {LONGEST_NAME} printable characters")
    bare = Signature(signer, datetime.now(UTC).isoformat(timespec="seconds"), sha256)
    proof = _private(key).sign(bare.said)
    return Signature(bare.signer, bare.time, sha256, base64.b64encode(proof).decode())


def public(key: bytes) -> str:
    """The public half of a private key, as a file of trusted keys has it. Raises UsageError."""
    return base64.b64encode(_private(key).public_key().public_bytes_raw()).decode()


def _private(pem: bytes) -> Ed25519PrivateKey:
    try:
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
        from cryptography.hazmat.primitives.serialization import load_pem_private_key
    except ImportError:
        raise UsageError(NEEDED) from None
    try:
        key: Any = load_pem_private_key(pem, None)
    except (ValueError, TypeError) as error:
        raise UsageError(f"the key is no private key in PEM without a password ({error})") from None
    if not isinstance(key, Ed25519PrivateKey):
        raise UsageError("the key is none of Ed25519: openssl genpkey -algorithm ed25519 makes one")
    return key


class Trusted:
    """The keys whose limits count, by name: base64 of the 32 bytes of each."""

    def __init__(self, keys: Mapping[str, bytes]) -> None:
        self.keys = keys
        self._known: dict[tuple[str, str], str] = {}

    def problem(self, signature: str, sha256: str) -> str:
        """Why limits of that digest are not signed by a key of these; "": they are."""
        asked = (signature, sha256)
        if asked not in self._known:
            self._known[asked] = self._problem(signature, sha256)
        return self._known[asked]

    def _problem(self, text: str, sha256: str) -> str:
        from cryptography.exceptions import InvalidSignature
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

        if not text:
            return "nobody signed them"
        try:
            found = parse(text)
            proof = base64.b64decode(found.signature, validate=True)
        except ValueError:
            return "their signature is damaged"
        if found.sha256 != sha256:
            return f"the signature of {found.signer} is for other limits: sign them anew"
        key = self.keys.get(found.signer)
        if key is None:
            return f"the key {found.signer} that signed them is not trusted"
        try:
            Ed25519PublicKey.from_public_bytes(key).verify(proof, found.said)
        except InvalidSignature:
            return f"their signature is not of the trusted key {found.signer}"
        return ""


def read_trusted(path: Path) -> Trusted:
    """A file of trusted keys. Raises UsageError, or DataError where a key in it is none."""
    try:
        import cryptography  # noqa: F401
    except ImportError:
        raise UsageError(NEEDED) from None
    text = read_text(path, "a file of trusted keys", UsageError)
    document = tables_of(text, str(path), UsageError)
    if problem := unknown(document, ("keys",)):
        raise UsageError(f"{path}: {problem}")
    keys, found = document.get("keys"), {}
    if not isinstance(keys, dict) or not keys:
        raise UsageError(f"{path}: [keys] names none: motorid product public prints a line for it")
    for name, value in keys.items():
        try:
            found[name] = base64.b64decode(str(value), validate=True)
        except (binascii.Error, ValueError):
            found[name] = b""
        if len(found[name]) != 32:
            raise DataError(f"{path}: keys.{name} is no public key of Ed25519 in base64")
    return Trusted(found)
