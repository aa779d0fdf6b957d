"""The pictures of the pages that walk.py runs, by Chromium without a window.

    python -m tools.site.pictures              # all of them
    python -m tools.site.pictures gallery      # those of one page

They are reduced to 64 colours, which a report does not need more of.
"""

from __future__ import annotations

import io
import sys
import tempfile
from pathlib import Path

from PIL import Image

from tests import chromium
from tools.site import walk

COLOURS = 64


def shoot(browser: chromium.Page, picture: walk.Picture, folder: Path) -> Path:
    """A window on a page of a folder, as a PNG."""
    browser.size(picture.width, picture.height)
    browser.open((folder / picture.page).as_uri())
    browser.wait("document.readyState == 'complete' && location.protocol == 'file:'")
    image = walk.DOCS / picture.image
    image.parent.mkdir(exist_ok=True)
    shown = Image.open(io.BytesIO(browser.shot()))
    shown.convert("RGB").quantize(COLOURS).save(image, optimize=True)
    return image


def main(names: list[str]) -> int:
    """Makes the pictures of the named pages, or of all."""
    pages = [page for page in walk.pages() if not names or page.stem in names]
    with chromium.opened(chromium.found()) as opened:
        for page in pages:
            with tempfile.TemporaryDirectory() as folder:
                for step in walk.steps(page.read_text(encoding="utf-8")):
                    if isinstance(step, walk.Commands):
                        print(walk.run(step, Path(folder)))
                        continue
                    image = shoot(opened(), step, Path(folder))
                    print(f"{image.relative_to(walk.ROOT)}: {image.stat().st_size} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
