"""Pages whose commands are run, one after the other, in one folder.

Those in a block after ``<!-- run -->`` are; ``<!-- run 1 -->`` says that the block's last command
ends with that code. ``<!-- picture: PAGE WxH -->`` before an image says which page, written by the
commands so far, it shows in a window of that size.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
STEP = re.compile(
    r"^<!-- run(?: (?P<code>\d+))? -->\n```sh\n(?P<commands>.*?)^```"
    r"|^<!-- picture: (?P<page>\S+) (?P<width>\d+)x(?P<height>\d+) -->\n"
    r"!\[[^\]]*\]\((?P<image>[^)]+)\)",
    re.MULTILINE | re.DOTALL,
)
PATIENCE_S = 600.0


@dataclass(frozen=True)
class Commands:
    """Lines of a shell, and the exit code of the last of them."""

    lines: str
    code: int


@dataclass(frozen=True)
class Picture:
    """An image beside the page that it shows, in a window of that size in pixels."""

    page: str
    width: int
    height: int
    image: str


class WalkError(Exception):
    """A command ended otherwise than its page says."""


def steps(text: str) -> Iterator[Commands | Picture]:
    """What a page does, in its order."""
    for found in STEP.finditer(text):
        if found["commands"]:
            yield Commands(found["commands"], int(found["code"] or 0))
        else:
            size = int(found["width"]), int(found["height"])
            yield Picture(found["page"], *size, found["image"])


def pages() -> list[Path]:
    """The pages of docs/ that have steps."""
    named = sorted(DOCS.glob("*.md"))
    return [page for page in named if any(steps(page.read_text(encoding="utf-8")))]


def run(step: Commands, folder: Path) -> str:
    """What the commands print, with the programs of this Python first; raises WalkError."""
    bin_folder = str(Path(sys.executable).parent)
    done = subprocess.run(  # noqa: S603  # the documents' own words
        ["sh", "-e", "-c", step.lines],  # noqa: S607
        cwd=folder,
        env=os.environ | {"PATH": f"{bin_folder}{os.pathsep}{os.environ['PATH']}", "COLUMNS": "80"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    if done.returncode != step.code:
        raise WalkError(
            f"{step.lines}ended with {done.returncode}, not {step.code}:\n{done.stdout}"
        )
    return done.stdout
