"""What a browser makes of the report: something to see, and nothing to complain about."""

from __future__ import annotations

import struct
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.report import html
from tests import chromium
from tests.report.example import estimate

QUIET = (*chromium.QUIET, "--enable-logging=stderr", "--v=0")


@pytest.fixture(scope="module")
def browser() -> str:
    return chromium.found()


def shoot(browser: str, folder: Path, size: str) -> tuple[NDArray[np.uint8], str]:
    page, image = folder / "report.html", folder / f"{size}.png"
    page.write_text(html.render(estimate()), encoding="utf-8", newline="\n")
    done = subprocess.run(
        [browser, *QUIET, f"--user-data-dir={folder / 'profile'}", f"--screenshot={image}",
         f"--window-size={size}", page.as_uri()],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert image.exists(), done.stderr[-2000:]
    return pixels(image.read_bytes()), done.stderr


def pixels(png: bytes) -> NDArray[np.uint8]:
    """Pixels of an 8-bit RGB or RGBA PNG, shape (height, width, channels)."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    at, data, size = 8, b"", (0, 0, 0)
    while at < len(png):
        length, kind = struct.unpack(">I4s", png[at : at + 8])
        chunk = png[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", chunk[:10])
            assert depth == 8
            size = (height, width, {2: 3, 6: 4}[colour])
        data += chunk if kind == b"IDAT" else b""
        at += 12 + length
    return _unfiltered(zlib.decompress(data), *size)


def _unfiltered(data: bytes, height: int, width: int, channels: int) -> NDArray[np.uint8]:
    lines = np.frombuffer(data, np.uint8).reshape(height, 1 + width * channels)
    out = np.zeros((height, width * channels), dtype=np.uint8)
    for y in range(height):
        kind, line = lines[y, 0], lines[y, 1:]
        above = out[y - 1] if y else np.zeros_like(line)
        if kind in (0, 2):
            out[y] = line + (above if kind == 2 else 0)
            continue
        for x in range(channels):  # each colour by itself, from the left
            out[y, x::channels] = _row(int(kind), line[x::channels], above[x::channels])
    return out.reshape(height, width, channels)


def _row(kind: int, line: NDArray[np.uint8], above: NDArray[np.uint8]) -> NDArray[np.uint8]:
    if kind == 1:
        return np.cumsum(line, dtype=np.uint8)
    out, left, corner = [], 0, 0
    for value, up in zip(line.tolist(), above.tolist(), strict=True):
        if kind == 3:
            guess = (left + up) // 2
        else:
            distances = (abs(up - corner), abs(left - corner), abs(left + up - 2 * corner))
            guess = (left, up, corner)[distances.index(min(distances))]
        left, corner = (value + guess) & 255, up
        out.append(left)
    return np.array(out, dtype=np.uint8)


@pytest.mark.slow
@pytest.mark.parametrize("size", ["1200,1600", "500,1200"])
def test_a_browser_shows_the_report_without_complaint(
    browser: str, tmp_path: Path, size: str
) -> None:
    image, said = shoot(browser, tmp_path, size)
    assert "CONSOLE" not in said  # Chromium logs what a page's console would show
    width = int(size.split(",")[0])
    assert image.shape[1] == width
    grey = image[..., :3].astype(np.int64).mean(axis=2)
    paper = np.median(grey)
    inked = np.abs(grey - paper) > 40
    assert 0.01 < inked.mean() < 0.5
    bands = np.array_split(inked, 8)
    assert all(band.any() for band in bands)  # something on every part of the first screens
    edge = inked[:, -4:]
    assert not edge.any()  # nothing runs over the right edge
    spread = np.ptp(image[..., :3].astype(np.int64), axis=2)
    assert (spread > 60).sum() > 500  # the curves have colours
