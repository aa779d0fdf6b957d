"""Builds the compiled motor responses (``motorid.motor._response``).

response.h and wide.h are its interfaces.

Run it alone to rebuild in place: ``python motorid/motor/response_build.py``.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from cffi import FFI

ROOM = Path(__file__).parent
SOURCES = (
    "response.c", "wide.c", "wide_plan.c", "wide_step.c", "wide_map.c", "wide_lanes.c",
    "wide_lanes_avx2.c", "phi.c",
    "taps.c", "affine.c", "wave.c", "root.c", "filter.c", "filtered_wave.c", "filtered_motor.c",
    "guard.c",
)  # fmt: skip
HEADERS = (
    "response.h",
    "wide.h",
    "wide_run.h",
    "wide_step.h",
    "wide_map.h",
    "wide_iron.h",
    "wide_lanes.h",
    "wide_lanes_kernel.h",
    "instructions.h",
    "phi.h",
    "taps.h",
    "affine.h",
    "wave.h",
    "root.h",
    "filter.h",
    "filtered_wave.h",
    "filtered_motor.h",
    "guard.h",
)

FLAGS = (
    ["/O2", "/fp:precise"]
    if sys.platform == "win32"
    else [
        "-O3",
        "-std=c99",
        "-ffp-contract=off",
        "-fno-trapping-math",
        "-fno-math-errno",
        "-Wno-psabi",
    ]
)


def declarations(header: str) -> str:
    """The part of the header that cffi reads: no comments, no preprocessor lines."""
    bare = re.sub(r"/\*.*?\*/", "", header, flags=re.DOTALL)
    return "\n".join(line for line in bare.splitlines() if not line.startswith("#"))


ffi = FFI()
for interface in ("response.h", "wide.h"):
    ffi.cdef(declarations((ROOM / interface).read_text(encoding="utf-8")))
ffi.set_source(
    "motorid.motor._response",
    '#include "response.h"\n#include "wide.h"',
    # relative to the project's root, where setup.py runs: absolute paths do not survive an sdist
    sources=[f"motorid/motor/{name}" for name in SOURCES],
    include_dirs=["motorid/motor"],
    depends=[f"motorid/motor/{name}" for name in (*SOURCES, *HEADERS)],
    libraries=[] if sys.platform == "win32" else ["m"],
    extra_compile_args=FLAGS,
)

if __name__ == "__main__":
    ffi.compile(tmpdir=str(ROOM.parent.parent), verbose=False)
