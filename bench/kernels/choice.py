"""The kernels of OpenBLAS that this processor can run."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

# oldest first; OpenBLAS names them after the first processors that they suit
X86 = ("Nehalem", "Sandybridge", "Haswell", "Zen", "SkylakeX", "Cooperlake", "SapphireRapids")
ARM = ("ARMV8", "CORTEXA57", "NEOVERSEN1", "NEOVERSEV1")
KNOWN = X86 + ARM
SYMBOLS = ("scipy_openblas_get_corename64_", "scipy_openblas_get_corename")
PROBE = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy as np, scipy.linalg
from bench.kernels.choice import in_force
a = np.random.default_rng(0).standard_normal((64, 64))
for linalg in (np.linalg, scipy.linalg):  # what a kernel may be too new for stops here
    linalg.svd(a), linalg.solve(a, a), linalg.qr(a @ a)
print(*in_force())
"""
ROOT = Path(__file__).resolve().parents[2]


def environment(kernel: str) -> dict[str, str]:
    """What makes a new process use that kernel; "" leaves the choice to OpenBLAS."""
    alone = {"OPENBLAS_NUM_THREADS": "1"}  # the same order of additions every time
    return alone | ({"OPENBLAS_CORETYPE": kernel} if kernel else {})


def in_force() -> tuple[str, ...]:
    """The kernels of this process: of every OpenBLAS that is loaded. Linux only; else none."""
    return tuple(sorted(set(_corenames())))


def _corenames() -> Iterator[str]:
    maps = Path("/proc/self/maps")
    lines = maps.read_text().splitlines() if maps.exists() else []
    for path in sorted({line.split()[-1] for line in lines if "openblas" in line}):
        library = ctypes.CDLL(path)
        for symbol in SYMBOLS:
            if hasattr(library, symbol):
                function = getattr(library, symbol)
                function.restype = ctypes.c_char_p
                yield function().decode()


def others(own: str, wanted: Sequence[str] = KNOWN) -> list[str]:
    """Those of ``wanted`` that run here and are what they are asked to be, but for ``own``."""
    return [kernel for kernel in wanted if kernel != own and probed(kernel) == kernel]


def probed(kernel: str) -> str | None:
    """The one kernel that is in force where this one is asked for; None: it crashes, or differs
    between numpy and scipy.
    """
    command = [sys.executable, "-c", PROBE, str(ROOT)]
    done = subprocess.run(
        command, env=os.environ | environment(kernel), capture_output=True, text=True, check=False
    )
    names = done.stdout.split() if done.returncode == 0 else []
    return names[0] if len(names) == 1 else None


def checked(kernel: str, found: Mapping[str, object]) -> None:
    """Raises SystemExit where a child ran under another kernel than it was told."""
    if found["kernels"] != [kernel]:
        sys.exit(f"asked for the kernel {kernel}, and {found['kernels']} was in force")
