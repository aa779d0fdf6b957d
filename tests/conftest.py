"""What every test shares: the folder of real measurements, fixed seeds, and an account of skips."""

from __future__ import annotations

import gc
import os
import signal
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path

import hypothesis
import pytest

ROOT = Path(__file__).resolve().parent.parent
SHARED_DATA = ROOT.parent / "shared" / "data"
ALLOWED_SKIPS = ROOT / "tests" / "allowed_skips.toml"

# Before numpy is loaded, and for every process that a test starts: one thread of linear algebra a
# worker. More of them wait for each other by turning in circles where cores are shared (a fit then
# takes three times the processor's time), and sums come out in another order on another machine.
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

# A shell may have told this process to ignore a closed terminal (nohup) or Ctrl-C (what it began in
# the background); tests and what they start must not.
if hasattr(signal, "SIGHUP"):
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# The same examples on every run, and no deadline: a busy machine is not a failing property.
hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None)
hypothesis.settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def repo_root() -> Path:
    """The folder that holds pyproject.toml."""
    return ROOT


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Real measurements kept beside the repository; they are not part of it."""
    if not SHARED_DATA.is_dir():
        pytest.skip("no ../shared/data: the real measurements are kept outside this repository")
    return SHARED_DATA


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.get_closest_marker("long") is None)  # the rest stay in order
    if config.getoption("--device") is None:
        _leave_out(config, items, [item for item in items if _is_of_a_device(item)])
    if not config.getoption("--studies"):
        _leave_out(config, items, [item for item in items if item.get_closest_marker("study")])


def _leave_out(
    config: pytest.Config, items: list[pytest.Item], others: Sequence[pytest.Item]
) -> None:
    config.hook.pytest_deselected(items=others)
    left_out = set(others)
    items[:] = [item for item in items if item not in left_out]


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[object]:
    """Thousands of tests and modules stay to the end: the collector need not look at them."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.collect()
        gc.freeze()


def _is_of_a_device(item: pytest.Item) -> bool:
    callspec = getattr(item, "callspec", None)
    return callspec is not None and callspec.params.get("board_name") == "device"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--device", help="port of a real board whose motor may turn; without it, the "
                     "conformance suite's cases for a real board are deselected")  # fmt: skip
    parser.addoption(
        "--first-rows",
        action="store_true",
        help="of the conformance suite's tables the first row on a real board as on emulated ones, "
        "but for what guards safety",
    )
    parser.addoption(
        "--studies",
        action="store_true",
        help="with the tests that take so long that they belong to the evidence",
    )
    parser.addoption(
        "--strict-skips",
        action="store_true",
        help="fail when a test skips for a reason that tests/allowed_skips.toml does not list",
    )


def _skip_reasons(config: pytest.Config) -> dict[str, int]:
    """How often each reason was given, in this run."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    counts: dict[str, int] = {}
    for report in reporter.stats.get("skipped", []) if reporter else []:
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        reason = reason.removeprefix("Skipped: ")
        counts[reason] = counts.get(reason, 0) + 1
    return counts


def _allowed() -> tuple[str, ...]:
    entries = tomllib.loads(ALLOWED_SKIPS.read_text(encoding="utf-8")).get("skip", [])
    everything = os.environ.get("CI") == "true"  # there, what can be installed is installed
    return tuple(
        entry["reason_begins"] for entry in entries if not (everything and entry.get("installable"))
    )


def _refused_skips(config: pytest.Config) -> list[str]:
    if not config.getoption("--strict-skips"):
        return []
    allowed = _allowed()
    return [reason for reason in _skip_reasons(config) if not reason.startswith(allowed)]


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    on_worker = hasattr(session.config, "workerinput")  # xdist: only the controller judges
    passed = session.exitstatus == pytest.ExitCode.OK
    if passed and not on_worker and _refused_skips(session.config):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    counts = _skip_reasons(config)
    refused = _refused_skips(config)
    if counts:
        terminalreporter.section("skipped, and why")
    for reason, count in sorted(counts.items()):
        mark = "NOT ALLOWED: " if reason in refused else ""
        terminalreporter.line(f"{count:4d} x {mark}{reason}", red=reason in refused)
