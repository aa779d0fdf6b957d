"""The fits of another commit, on this machine and this corpus."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tests.frozen import compare, fits
from tests.frozen.compare import Difference
from tests.frozen.fits import ROOT

C_FILES = ("*_build.py", "*.c", "*.h")


def against(revision: str, names: Sequence[str]) -> list[Difference]:
    """Every bit in which the present fits of these cases differ from that commit's."""
    with checked_out(revision) as folder:
        before = fits.in_child(names, folder)
    after = fits.in_child(names)
    for name in names:
        print(f"{name:<28}{before[name].seconds:6.2f} s -> {after[name].seconds:.2f} s")
    return [
        d for name in names for d in compare.bits(name, before[name].values, after[name].values)
    ]


@contextmanager
def checked_out(revision: str) -> Iterator[Path]:
    """A folder with the package as it was, its C compiled; gone afterwards."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "package"
        git("worktree", "add", "--quiet", "--detach", str(folder), revision)
        try:
            compiled(folder)
            yield folder
        finally:
            git("worktree", "remove", "--force", str(folder))


def git(*arguments: str) -> None:
    """Raises SystemExit with what git says."""
    done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"git {arguments[0]}: {done.stderr.strip()}")


def compiled(folder: Path) -> None:
    """Takes over what is compiled here, where its sources are the same; else compiles."""
    if sources(folder) == sources(ROOT):
        for library in (ROOT / "motorid").rglob("*.so"):
            shutil.copy2(library, folder / library.relative_to(ROOT))
        return
    command = [sys.executable, "setup.py", "--quiet", "build_ext", "--inplace"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"the C of that commit does not compile: {done.stderr[-2000:]}")


def sources(folder: Path) -> dict[str, bytes]:
    """The C of a checkout, but for what cffi writes itself."""
    package = folder / "motorid"
    return {
        path.relative_to(package).as_posix(): path.read_bytes()
        for pattern in C_FILES
        for path in package.glob(f"*/{pattern}")
        if not path.name.startswith("_")
    }
