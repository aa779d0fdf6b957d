"""The lock: each package that ``make run`` and ``make test`` install, with its files' hashes.

    python -m tools.supply.lock             write locks/, versions as they are
    python -m tools.supply.lock --upgrade   write locks/ with the newest versions
    python -m tools.supply.lock --check     do locks, pyproject.toml and this environment agree?

Writing asks the package index. Checking reads files alone.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tools.supply.packages import (
    COMPILER_LOCK,
    LOCKS,
    ROOT,
    SupplyError,
    closure,
    installed,
    pins,
    wanted,
    wanted_compiler,
)

OLDEST = "3.11"  # Python; requires-python of pyproject.toml


def write(upgrade: bool) -> None:
    """Resolves for every platform and Python at once; what is run is a part of what is tested."""
    newest = ["--upgrade"] if upgrade else []
    resolve(LOCKS["test"], wanted("test"), *newest)
    resolve(LOCKS["run"], wanted("run"), "--constraints", str(LOCKS["test"]), *newest)
    resolve(COMPILER_LOCK, wanted_compiler())


def resolve(lock: Path, named: Iterable[Requirement], *options: str) -> None:
    """Writes one lock file."""
    command = [sys.executable, "-m", "uv", "pip", "compile", "-", "--quiet", "--no-header"]
    command += ["--universal", "--python-version", OLDEST, "--generate-hashes"]
    command += ["--output-file", str(lock), *options]
    lock.parent.mkdir(exist_ok=True)
    subprocess.run(  # noqa: S603  # our own words
        command, input="\n".join(map(str, named)), text=True, check=True, cwd=ROOT
    )


def faults() -> Iterator[str]:
    """A sentence for each thing that is out of step, without asking any network."""
    locked = {what: pins(path) for what, path in LOCKS.items()}
    for name, pin in locked["run"].items():
        if locked["test"].get(name) != pin:
            yield f"{name}: locks/run.txt and locks/test.txt differ"
    for what, table in locked.items():
        needed = closure(wanted(what))
        for name, requirements in needed.items():
            if name not in table:
                yield f"{name}: needed, but not in locks/{what}.txt"
                continue
            version = table[name].version
            for one in requirements:
                if not one.specifier.contains(version, prereleases=True):
                    yield f"{name} {version}: locks/{what}.txt does not meet {one}"
        for name in sorted(table.keys() - needed.keys()):
            if table[name].applies:
                yield f"{name}: in locks/{what}.txt, but nothing needs it"
    yield from compiler_faults()
    for name, pin in locked["test"].items():
        if pin.applies and installed(name).version != pin.version:
            yield f"{name}: {installed(name).version} is installed, {pin.version} is locked"


def compiler_faults() -> Iterator[str]:
    """The same of the compiler's lock, which no environment follows."""
    locked = pins(COMPILER_LOCK)
    needed = {canonicalize_name(one.name): one for one in wanted_compiler()}
    for name in sorted(needed.keys() | locked.keys()):
        if name not in locked or name not in needed:
            yield f"{name}: in one of locks/{COMPILER_LOCK.name} and pyproject.toml"
        elif not needed[name].specifier.contains(locked[name].version):
            yield f"{name} {locked[name].version}: locks/{COMPILER_LOCK.name} is not {needed[name]}"


def main(arguments: list[str]) -> int:
    """Exit code 1 where ``--check`` finds something out of step."""
    if "--check" not in arguments:
        write("--upgrade" in arguments)
        return 0
    try:
        found = list(faults())
    except SupplyError as error:
        found = [str(error)]
    for sentence in found:
        print(sentence, file=sys.stderr)
    if found:
        print("write the lock: make lock; install it: make .venv/ready-to-test", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
