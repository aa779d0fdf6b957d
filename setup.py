"""The compiled parts and the packaged rigs and products; everything else is in pyproject.toml."""

import os
from collections.abc import Iterable
from pathlib import Path

from setuptools import setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py


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
        if os.environ.get("MOTORID_RELEASE"):
            self.put_inside("firmware", Path("firmware/build/release").glob("*"))

    def put_inside(self, folder: str, files: Iterable[Path]) -> None:
        inside = Path(self.build_lib, "motorid", folder)
        self.mkpath(str(inside))
        for file in files:
            self.copy_file(str(file), str(inside / file.name))


class BuildOne(build_ext):
    """Leaves one library a module: Python would load an older one with a more exact suffix."""

    def run(self) -> None:
        super().run()
        for part in self.extensions if self.inplace else ():
            built = Path(self.get_ext_fullpath(part.name))
            module = built.name.partition(".")[0]
            for other in built.parent.glob(f"{module}.*"):
                if other.suffix == built.suffix and other.name != built.name:
                    other.unlink()


setup(
    cmdclass={"build_ext": BuildOne, "build_py": BuildWithRigs},
    # each compiled part has its builder beside it
    cffi_modules=[f"{path}:ffi" for path in sorted(Path("motorid").glob("*/*_build.py"))],
)
