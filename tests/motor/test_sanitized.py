"""The compiled responses under the address and undefined-behaviour sanitizers.

By hand, for longer: compile as ``built`` does, then ``./driver FIRST_SEED HOW_MANY``.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from motorid.motor.response_build import ROOM, SOURCES

RUNS = 300  # a third of them sane, a third with a rare hostile value, a third with many


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which("gcc") or shutil.which("clang")
    if not compiler:
        pytest.skip("no make and gcc: the C parts cannot be compiled here")
    driver = tmp_path_factory.mktemp("sanitized") / "driver"
    sources = [str(ROOM / name) for name in SOURCES]
    main = Path(__file__).with_name("sanitized_main.c")
    subprocess.run(
        [compiler, "-std=c99", "-O1", "-g", "-Wall", "-Wextra", "-fsanitize=address,undefined",
         "-fsanitize=float-cast-overflow", "-fno-sanitize-recover=all", f"-I{ROOM}",
         str(main), *sources, "-lm", "-o", str(driver)],
        check=True,
    )  # fmt: skip
    return driver


@pytest.mark.slow
@pytest.mark.study
def test_no_argument_reaches_beyond_the_buffers(built: Path) -> None:
    done = subprocess.run([str(built), "0", str(RUNS)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    answered = int(done.stdout)
    assert RUNS < answered < 3 * RUNS  # most are answered, by three ways; some are refused
