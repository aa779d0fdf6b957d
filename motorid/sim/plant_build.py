"""Compiles the plant and its sensors into ``motorid.sim._plant``; HEADERS are the interface."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from cffi import FFI

ROOM = Path(__file__).parent
HEADERS = ("lowpass.h", "plant.h", "sensors.h")
PRIVATE = ("bridge.h", "equations.h", "iron.h")
SOURCES = ("plant.c", "equations.c", "iron.c", "bridge.c", "lowpass.c", "sensors.c")


def _declarations(header: str) -> str:
    """The header without its preprocessor lines, which cffi does not read."""
    text = (ROOM / header).read_text(encoding="utf-8")
    return re.sub(r"^#.*$", "", text, flags=re.MULTILINE)


ffi = FFI()
for _header in HEADERS:
    ffi.cdef(_declarations(_header))
ffi.set_source(
    "motorid.sim._plant",
    '#include "sensors.h"',
    # relative to the project's root, where setup.py runs: absolute paths do not survive an sdist
    sources=[f"motorid/sim/{name}" for name in SOURCES],
    include_dirs=["motorid/sim"],
    depends=[f"motorid/sim/{name}" for name in (*SOURCES, *HEADERS, *PRIVATE)],
    libraries=[] if sys.platform == "win32" else ["m"],
    extra_compile_args=["/O2"] if sys.platform == "win32" else ["-O3", "-std=c99"],
)

if __name__ == "__main__":
    ffi.compile(tmpdir=str(ROOM.parent.parent), verbose=True)
