"""The compiled parts and the packaged rigs; everything else is in pyproject.toml."""

from pathlib import Path

from setuptools import setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py


class BuildWithRigs(build_py):
    """Puts rigs/ inside the installed package, so that ``--rig sim`` works from any folder."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return  # a working copy reads rigs/ itself
        inside = Path(self.build_lib, "motorid", "rigs")
        self.mkpath(str(inside))
        for rig in Path("rigs").glob("*.toml"):
            self.copy_file(str(rig), str(inside / rig.name))


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
