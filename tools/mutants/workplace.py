"""A copy of the repository in which mutants live, and pytest is run there."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from importlib.util import cache_from_source
from pathlib import Path

from tools.mutants.mutant import ROOT

HOME = ROOT / "out" / "mutants"
TREE = HOME / "tree"
KINDS = (".so", ".pyd")  # of the compiled parts, which no commit holds
TIMED_OUT = -1000  # in place of an exit code
LOOK = 2.0  # seconds between two looks at what runs
IDLE = 30  # looks without work: no test waits so long


def git(*words: str) -> str:
    """What git prints."""
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout


def copied() -> Path:
    """The files under version control as they are now, with the compiled parts."""
    shutil.rmtree(TREE, ignore_errors=True)
    named = git("ls-files", "-z")
    built = [
        path.relative_to(ROOT) for path in (ROOT / "motorid").rglob("*") if path.suffix in KINDS
    ]
    for name in [*map(Path, filter(None, named.split("\0"))), *built]:
        if (ROOT / name).is_file():
            (TREE / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, TREE / name)
    shared = ROOT.parent / "shared"
    if shared.is_dir() and not (HOME / "shared").exists():
        (HOME / "shared").symlink_to(shared, target_is_directory=True)
    return TREE


def put(path: str, content: bytes) -> None:
    """Writes a file of the copy, without its byte code: a stamp in whole seconds hides a change."""
    (TREE / path).write_bytes(content)
    if path.endswith(".py"):
        Path(cache_from_source(str(TREE / path))).unlink(missing_ok=True)


def run(command: Sequence[str], more: Mapping[str, str], of_processor: float) -> tuple[int, str]:
    """Runs a command in the copy, and ends all that it started: its exit code, its last words.

    Each of its processes may take so many seconds ``of_processor``. All of them may wait for
    ``IDLE`` looks in a row. No clock on the wall ends it: a busy machine would change the answer.
    """
    environment = {**os.environ, "PYTHONPATH": str(TREE), **more}
    environment["PYTHONDONTWRITEBYTECODE"] = ""  # else each mutant compiles all modules anew
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        environment[name] = "1"
    with (HOME / "said.txt").open("w+", encoding="utf-8", errors="replace") as said:
        process = subprocess.Popen(
            command, cwd=TREE, env=environment, stdin=subprocess.DEVNULL,
            stdout=said, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
        _bound(process.pid, max(round(of_processor), 1))
        try:
            code = _ended(process)
        finally:
            _end(process)
        said.seek(0)
        return code, said.read()[-3000:]


def _ended(process: subprocess.Popen[bytes]) -> int:
    """The exit code, or that the session waits for what never comes."""
    before, idle = -1, 0
    while idle < IDLE:
        try:
            code = process.wait(timeout=LOOK)
            return TIMED_OUT if code == -signal.SIGXCPU else code
        except subprocess.TimeoutExpired:
            ready, spent = _work(process.pid)
            idle = 0 if ready or spent != before else idle + 1
            before = spent
    return TIMED_OUT


def _work(session: int) -> tuple[bool, int]:
    """Of a session's processes: whether one could run now, and what they all have run, in ticks."""
    ready, spent = False, 0
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = entry.read_text().rpartition(")")[2].split()
        except OSError:  # ended since it was listed
            continue
        if int(fields[3]) == session:
            ready = ready or fields[0] in "RD"
            spent += int(fields[11]) + int(fields[12])
    return ready, spent


def _bound(pid: int, seconds: int) -> None:
    """What turns in circles ends after so much work, however busy the machine is."""
    import resource

    resource.prlimit(pid, resource.RLIMIT_CPU, (seconds, seconds + 1))


def _end(process: subprocess.Popen[bytes]) -> None:
    """The whole session of the process: a mutant may leave children that turn in circles."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        return
    finally:
        process.wait()


def pytest(*arguments: str) -> list[str]:
    """The words that start it with the plug-in."""
    return [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "tools.mutants.plugin",
        "-p",
        "no:cacheprovider",
        *arguments,
    ]
