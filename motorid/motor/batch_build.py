"""Builds ``motorid.motor._batch`` from batch.c, at installation; batch.h is its interface."""

import re
import sys
from pathlib import Path

from cffi import FFI

ROOM = Path(__file__).parent
SOURCES = ("batch.c", "batch_avx2.c")
HEADERS = ("batch.h", "batch_kernels.h", "instructions.h")
FLAGS = (
    ["/O2", "/fp:precise"]
    if sys.platform == "win32"
    else ["-O3", "-std=gnu11", "-ffp-contract=off", "-fno-trapping-math", "-fno-math-errno"]
)

ffi = FFI()
ffi.cdef(re.sub(r"^#.*$", "", (ROOM / "batch.h").read_text(encoding="utf-8"), flags=re.MULTILINE))
ffi.set_source(
    "motorid.motor._batch",
    '#include "batch.h"',
    # relative to the project's root, where setup.py runs: absolute paths do not survive an sdist
    sources=[f"motorid/motor/{name}" for name in SOURCES],
    include_dirs=["motorid/motor"],
    depends=[f"motorid/motor/{name}" for name in (*SOURCES, *HEADERS)],
    libraries=[] if sys.platform == "win32" else ["m"],
    extra_compile_args=FLAGS,
)

if __name__ == "__main__":
    ffi.compile(tmpdir=str(ROOM.parent.parent), verbose=True)
