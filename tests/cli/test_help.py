"""Help that helps: an example in each command, and documents in step with it."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import click
import pytest

from motorid.cli.main import COMMANDS, cli


def command(name: str) -> click.Command:
    found = cli.get_command(click.Context(cli), name)
    assert found is not None
    return found


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_an_example_of_itself(name: str) -> None:
    title, *lines = (command(name).epilog or "").removeprefix("\b\n").splitlines()
    assert title == "Example:"
    assert [line for line in lines if line.split()[:2] == ["motorid", name]]


@pytest.mark.parametrize("name", COMMANDS)
def test_examples_parse(name: str) -> None:
    """An example that the command itself would refuse is worse than none."""
    joined = (command(name).epilog or "").replace("\\\n", " ")  # as a shell joins them
    lines = [line.strip() for line in joined.splitlines()]
    for line in lines:
        words = shlex.split(line)
        if words[:2] != ["motorid", name]:
            continue
        parser = command(name).make_parser(click.Context(command(name)))
        parser.parse_args(words[2:])


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_is_explained(name: str) -> None:
    for parameter in command(name).params:
        if isinstance(parameter, click.Option):
            assert parameter.help, parameter.name


@pytest.mark.slow
def test_commands_page_is_in_step(repo_root: Path) -> None:
    script = repo_root / "tools" / "commands_page.py"
    done = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_commands_page_names_every_command(repo_root: Path) -> None:
    page = (repo_root / "docs" / "commands.md").read_text(encoding="utf-8")
    assert [name for name in COMMANDS if f"## motorid {name}\n" not in page] == []
