"""The compiled parts and the packaged rigs; everything else is in pyproject.toml."""

from pathlib import Path

from setuptools import setup
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


setup(
    cmdclass={"build_py": BuildWithRigs},
    # each compiled part has its builder beside it
    cffi_modules=[f"{path}:ffi" for path in sorted(Path("motorid").glob("*/*_build.py"))],
)
