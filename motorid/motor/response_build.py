"""Builds the compiled motor response (``motorid.motor._response``) from response.c and response.h.

Run it alone to rebuild in place: ``python motorid/motor/response_build.py``.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from cffi import FFI

HERE = Path(__file__).parent


def declarations(header: str) -> str:
    """The part of the header that cffi reads: no comments, no preprocessor lines."""
    bare = re.sub(r"/\*.*?\*/", "", header, flags=re.DOTALL)
    return "\n".join(line for line in bare.splitlines() if not line.startswith("#"))


ffi = FFI()
ffi.cdef(declarations((HERE / "response.h").read_text(encoding="utf-8")))
ffi.set_source(
    "motorid.motor._response",
    (HERE / "response.c").read_text(encoding="utf-8"),
    include_dirs=[str(HERE)],
    depends=[str(HERE / "response.c"), str(HERE / "response.h")],
    extra_compile_args=["/O2"] if sys.platform == "win32" else ["-O3"],
)

if __name__ == "__main__":
    ffi.compile(tmpdir=str(HERE.parent.parent), verbose=False)
