"""Every command of docs/import.md is run as it stands there, on the data that it names."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from motorid.cli.main import run

PAGE = Path(__file__).resolve().parents[2] / "docs" / "import.md"
COMMANDS = re.findall(r"^    motorid (.*)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
IMPORTS = [line for line in COMMANDS if line.startswith("import DATA/")]
FITS = [line for line in COMMANDS if line.startswith("fit")]


def test_the_page_has_an_example_of_each_kind() -> None:
    folders = {line.split("/")[1] for line in IMPORTS}
    assert folders == {"robotino", "emps", "pwm-rpm", "position-loop", "speed-bench", "frc-curves"}


@pytest.mark.slow
def test_every_documented_command_works(
    shared_data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for line in IMPORTS:
        assert run(shlex.split(line.replace("DATA/", f"{shared_data}/", 1))) == 0, line
    for line in FITS:
        if "log.h5" not in line:
            assert run(shlex.split(line)) == 0, line
