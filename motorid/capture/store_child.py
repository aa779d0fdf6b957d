"""Run as a program: a capture file -> its arrays, and its facts as JSON. See capture/child.py."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from motorid.capture.child import serve
from motorid.capture.store_pack import pack


def main(source: str, target: str) -> None:
    """Reads ``source`` and writes ``target``. Raises DataError."""
    from motorid.capture.store_read import read

    data = Path(source).read_bytes()
    capture = read(data, source, hashlib.sha256(data).hexdigest())
    del data
    np.savez(target, **pack(capture))


if __name__ == "__main__":
    serve(main, ["motorid.capture.store_read"])
