"""Debian's Chromium without a window, driven over its own protocol: what a page shows and does."""

from __future__ import annotations

import base64
import contextlib
import itertools
import json
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
QUIET = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--hide-scrollbars",
)  # fmt: skip
PATIENCE_S = 60.0


def found() -> str:
    """The browser of this machine; skips without one."""
    for name in BROWSERS:
        if path := shutil.which(name):
            return path
    pytest.skip("no Chromium here: install the package chromium to see pages in a browser")


class Page:
    """One page of a browser. Errors of its console are in ``complaints``."""

    def __init__(self, socket: Any) -> None:
        self._socket = socket
        self._numbers = itertools.count(1)
        self.complaints: list[str] = []
        for part in ("Page", "Runtime", "Log", "Network"):
            self.ask(f"{part}.enable")

    def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """One command of the protocol, and its result."""
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            said = json.loads(self._socket.recv(timeout=PATIENCE_S))
            if said.get("id") == number:
                assert "error" not in said, said
                result: dict[str, Any] = said["result"]
                return result
            self._note(said)

    def _note(self, said: dict[str, Any]) -> None:
        match said.get("method"):
            case "Runtime.exceptionThrown":
                self.complaints.append(json.dumps(said["params"]["exceptionDetails"])[:400])
            case "Log.entryAdded" if said["params"]["entry"]["level"] == "error":
                self.complaints.append(said["params"]["entry"]["text"])

    def open(self, url: str) -> None:
        """Goes there."""
        self.ask("Page.navigate", url=url)

    def run(self, code: str) -> Any:
        """The value of an expression in the page."""
        value, trouble = self._evaluated(code)
        assert trouble is None, trouble
        return value

    def wait(self, code: str) -> Any:
        """The value of an expression, once it is true. A page that is loading has few elements:
        what an expression lacks may come.
        """
        until = time.monotonic() + PATIENCE_S
        while True:
            value, trouble = self._evaluated(code)
            if value and trouble is None:
                return value
            stays = trouble or f"stays {value!r}"
            assert time.monotonic() < until, f"{code}: {stays}; {self.complaints}"
            time.sleep(0.05)

    def _evaluated(self, code: str) -> tuple[Any, str | None]:
        """The value of an expression, and what it threw."""
        done = self.ask("Runtime.evaluate", expression=code, returnByValue=True, awaitPromise=True)
        thrown = done.get("exceptionDetails")
        return done["result"].get("value"), None if thrown is None else json.dumps(thrown)[:400]

    def size(self, width: int, height: int) -> None:
        """Of the window, in CSS pixels."""
        self.ask(
            "Emulation.setDeviceMetricsOverride", width=width, height=height,
            deviceScaleFactor=1, mobile=False,
        )  # fmt: skip

    def scheme(self, name: str) -> None:
        """light or dark."""
        features = [{"name": "prefers-color-scheme", "value": name}]
        self.ask("Emulation.setEmulatedMedia", features=features)

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """pressed, released, moved or wheel, at a place of the window."""
        names = {k: f"mouse{k.capitalize()}" for k in ("pressed", "released", "moved", "wheel")}
        self.ask("Input.dispatchMouseEvent", type=names[kind], x=x, y=y, **more)

    def drag(self, x: float, y: float, to: float) -> None:
        """Along a horizontal line; a click where it goes nowhere."""
        button = {"button": "left", "clickCount": 1}
        self.mouse("moved", x, y)
        self.mouse("pressed", x, y, **button)
        if to != x:
            self.mouse("moved", (x + to) / 2, y, button="left", buttons=1)
            self.mouse("moved", to, y, button="left", buttons=1)
        self.mouse("released", to, y, **button)

    def close(self) -> None:
        """Ends the page."""
        self.ask("Page.close")
        self._socket.close()

    def shot(self) -> bytes:
        """The window as a PNG."""
        return base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"])


@contextlib.contextmanager
def opened(program: str) -> Iterator[Callable[[], Page]]:
    """A browser; what it gives opens a new page."""
    from websockets.sync.client import connect

    with _running(program) as (port, path), contextlib.ExitStack() as stack:

        def page() -> Page:
            with connect(f"ws://127.0.0.1:{port}{path}", max_size=None, close_timeout=1) as whole:
                made = {
                    "id": 1,
                    "method": "Target.createTarget",
                    "params": {"url": "about:blank"},
                }
                whole.send(json.dumps(made))
                target = json.loads(whole.recv(timeout=PATIENCE_S))["result"]["targetId"]
            url = f"ws://127.0.0.1:{port}/devtools/page/{target}"
            return Page(stack.enter_context(connect(url, max_size=None, close_timeout=1)))

        yield page


@contextlib.contextmanager
def _running(program: str) -> Iterator[tuple[int, str]]:
    """A browser with a new profile; where it listens.

    Its children outlive it by a moment and still write: what is left of the profile is nobody's.
    """
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [program, *QUIET, f"--user-data-dir={profile}", "--remote-debugging-port=0"]
        process = subprocess.Popen(
            [*command, "about:blank"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            yield _devtools(process, Path(profile) / "DevToolsActivePort")
        finally:
            process.terminate()
            process.wait(PATIENCE_S)


def _devtools(process: subprocess.Popen[bytes], file: Path) -> tuple[int, str]:
    """Where the browser listens, once it says so."""
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until:
        assert process.poll() is None, "the browser has ended"
        lines = file.read_text().splitlines() if file.exists() else []
        if len(lines) == 2:
            return int(lines[0]), lines[1]
        time.sleep(0.05)
    raise AssertionError("the browser does not say where it listens")
