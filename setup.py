"""The compiled parts and the packaged rigs and products; everything else is in pyproject.toml."""

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from setuptools import setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

sys.path.insert(0, "tools/building")  # a build runs in the project's root

import zig_build

try:
    ASKED = zig_build.asked()
except zig_build.BuildError as error:
    sys.exit(f"motorid: {error}")
TARGET = zig_build.TARGETS[ASKED] if ASKED else None  # None: the machine's own compiler builds


class BuildWithRigs(build_py):
    """Puts rigs/ and products/ inside the installed package: ``--rig sim`` works anywhere.

    So it does with the boards' firmware in a release, which is built before: see ``make wheel``.
    """

    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return  # a working copy reads them where they are
        for folder in ("rigs", "products"):
            self.put_inside(folder, Path(folder).glob("*.toml"))
        for folder in ("rigs/frontends", "rigs/instruments"):
            self.put_inside(folder, Path(folder).glob("*.toml"))
        if os.environ.get("MOTORID_RELEASE"):
            self.put_inside("firmware", Path("firmware/build/release").glob("*"))

    def put_inside(self, folder: str, files: Iterable[Path]) -> None:
        inside = Path(self.build_lib, "motorid", folder)
        self.mkpath(str(inside))
        for file in files:
            self.copy_file(str(file), str(inside / file.name))


class BuildOne(build_ext):
    """Leaves one library a module: Python would load an older one with a more exact suffix.

    With a TARGET, zig compiles.
    """

    def finalize_options(self) -> None:
        super().finalize_options()
        self.parallel = self.parallel or os.cpu_count()

    def run(self) -> None:
        super().run()
        for part in self.extensions if self.inplace else ():
            built = Path(self.get_ext_fullpath(part.name))
            module = built.name.partition(".")[0]
            for other in built.parent.glob(f"{module}.*"):
                if other.suffix == built.suffix and other.name != built.name:
                    other.unlink()

    def get_ext_filename(self, fullname: str) -> str:
        if TARGET is None:
            return str(super().get_ext_filename(fullname))
        return str(Path(*fullname.split("."))) + TARGET.suffix

    def build_extension(self, ext: Any) -> None:
        if TARGET is None:
            super().build_extension(ext)
            return
        output = Path(self.get_ext_fullpath(ext.name))
        work = Path(self.build_temp)
        try:
            zig_build.compile_module(TARGET, ext.sources, output, ext.include_dirs, work)
        except zig_build.BuildError as error:
            sys.exit(f"motorid: {error}")


class TaggedWheel(bdist_wheel):
    """A wheel for TARGET, and for each Python since the oldest that motorid supports."""

    def get_tag(self) -> tuple[str, str, str]:
        if TARGET is None:
            return super().get_tag()
        return zig_build.PYTHON_TAG, zig_build.ABI_TAG, TARGET.wheel


setup(
    cmdclass={"bdist_wheel": TaggedWheel, "build_ext": BuildOne, "build_py": BuildWithRigs},
    # each compiled part has its builder beside it
    cffi_modules=[f"{path}:ffi" for path in sorted(Path("motorid").glob("*/*_build.py"))],
)
