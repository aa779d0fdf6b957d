"""The live page under load: 4 kHz x 3 channels, watched by a browser, through a pseudo terminal.

    python bench/bench_live.py --seconds 600

A simulated board in a process of its own stands for hardware. The capture serves its page, a
headless Chromium draws it, and one more client never reads. Targets: no sample lost by the capture
or by the page, and at least 20 frames a second in each of 60 stretches.
"""

from __future__ import annotations

import argparse
import contextlib
import resource
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from websockets.sync.client import connect

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from motorid.acquire import record
from motorid.capture import store
from tests.acquire.rigs import sim_rig
from tests.chromium import Page, found, opened
from tests.load import pty
from tests.web.served import served

RATE_HZ, LEAST_FRAMES = 4000.0, 20.0
STRETCHES = 60  # of a run, each with its frames a second


@dataclass
class Drawn:
    """Frames a second that the page drew, one figure for each stretch of ``each_s``."""

    page: Page
    each_s: float
    rates: list[float] = field(default_factory=list)
    over: threading.Event = field(default_factory=threading.Event)

    def follow(self) -> None:
        """Until it is over; the last stretch, which is cut short, does not count."""
        count, at = self._count(), time.monotonic()
        while not self.over.wait(self.each_s):
            now, then = self._count(), time.monotonic()
            self.rates.append((now - count) / (then - at))
            count, at = now, then

    def _count(self) -> int:
        return int(self.page.run("motorid.figures.draws"))


@contextlib.contextmanager
def following(page: Page, each_s: float) -> Iterator[Drawn]:
    """The page's rates while a run goes on."""
    page.wait("globalThis.motorid")
    drawn = Drawn(page, each_s)
    thread = threading.Thread(target=drawn.follow)
    thread.start()
    try:
        yield drawn
    finally:
        drawn.over.set()
        thread.join()


def run(seconds: float, folder: Path) -> dict[str, object]:
    """What came of one watched capture."""
    plan = pty.program(seconds)
    rig = sim_rig(program=plan)
    limits = replace(rig.limits, run_time_s=seconds + 10)
    sampling = replace(rig.sampling, rate_hz=RATE_HZ)
    with (
        opened(found()) as browser,
        served(command="capture") as here,
        pty.terminal() as path,
        connect(here.socket, origin=here.origin, ping_interval=None, close_timeout=1) as asleep,  # type: ignore[arg-type]
    ):
        assert asleep
        page = browser()
        page.size(1280, 800)
        page.open(here.url)
        watched = replace(rig, port=path, limits=limits, sampling=sampling)
        with following(page, max(seconds / STRETCHES, 1.0)) as drawn:
            began = resource.getrusage(resource.RUSAGE_SELF)
            record.capture_all(watched, plan, [folder / "run.h5"], watch=here.tap.begin)
            ended = resource.getrusage(resource.RUSAGE_SELF)
        kept = store.load(folder / "run.h5")
        page.wait(f"motorid.figures.received >= {len(kept)}")
        seen = page.run("motorid.figures")
    link = kept.provenance["link"]
    spent = ended.ru_utime + ended.ru_stime - began.ru_utime - began.ru_stime
    return {
        "seconds": seconds,
        "samples expected": round(seconds * RATE_HZ),
        "samples of the capture": len(kept),
        "gaps of the capture": len(kept.gaps),
        "dropped by the board": link["done"]["dropped"],
        "samples on the page": seen["received"],
        "missing on the page": seen["missing"],
        "frames that the page was too slow for": seen["lost"],
        "frames drawn a second, least of a stretch": round(min(drawn.rates), 1),
        "frames drawn a second, mean": round(sum(drawn.rates) / len(drawn.rates), 1),
        "share of a core, capture and server": round(spent / seconds, 3),
    }


def main() -> int:
    """Exit code 1 where a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        result = run(options.seconds, Path(folder))
    for name, value in result.items():
        print(f"{name:45} {value}")
    expected = result["samples expected"]
    whole = result["samples of the capture"] == result["samples on the page"] == expected
    rate = float(str(result["frames drawn a second, least of a stretch"]))
    print("targets met" if whole and rate >= LEAST_FRAMES else "TARGET MISSED")
    return 0 if whole and rate >= LEAST_FRAMES else 1


if __name__ == "__main__":
    sys.exit(main())
