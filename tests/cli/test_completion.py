"""Completion, asked by the shells themselves: those that this machine has."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from motorid.cli import main
from motorid.cli.completion import SHELLS

HERE = [shell for shell in SHELLS if shutil.which(shell)]
BASH = """
eval "$(motorid completion bash)"
compopt() { echo "FILES"; }
COMP_WORDS=(%s); COMP_CWORD=$(( ${#COMP_WORDS[@]} - 1 ))
_motorid_completion motorid; printf '%%s\\n' "${COMPREPLY[@]}"
"""
ZSH = """
compdef() { :; }; _describe() { print -l -- ${(P)3}; }; compadd() { print -l -- ${(P)@[-1]}; }
_path_files() { print FILES; }
eval "$(motorid completion zsh)"
words=(%s); CURRENT=${#words}; _motorid_completion; exit 0
"""
FISH = "motorid completion fish | source; complete -C '%s'"


def asked(shell: str, line: str, folder: Path) -> str:
    """What a shell offers at the end of ``line``."""
    script = {"bash": BASH, "zsh": ZSH, "fish": FISH}[shell] % line
    path = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
    done = subprocess.run(
        [shell, "-c", script],
        cwd=folder,
        env={"PATH": path, "HOME": str(folder)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    return done.stdout


def test_bash_is_among_them() -> None:
    assert "bash" in HERE


@pytest.mark.slow
@pytest.mark.parametrize("shell", HERE)
def test_a_shell_completes_commands_options_and_rigs(shell: str, tmp_path: Path) -> None:
    lines = asked(shell, "motorid r", tmp_path).splitlines()
    assert {"run", "recover", "rigs"} <= {re.split("[\t:]", line)[0] for line in lines}
    assert "--strict" in asked(shell, "motorid fit --st", tmp_path)
    assert "sim-qube" in asked(shell, "motorid run --rig sim-q", tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("shell", HERE)
def test_a_shell_completes_files(shell: str, tmp_path: Path) -> None:
    (tmp_path / "run-1.h5").touch()
    found = asked(shell, "motorid fit run-", tmp_path)
    assert "FILES" in found or "run-1.h5" in found


@pytest.mark.parametrize("shell", SHELLS)
def test_the_script_names_the_command_and_its_variable(
    shell: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(["completion", shell]) == 0
    said = capsys.readouterr().out
    assert f"_MOTORID_COMPLETE={shell}_complete" in said
