"""The board under test: each test runs once for every board that has the traits it needs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from tests.conformance.boards import (
    NAMES,
    Board,
    DeviceBoard,
    EmulatedBoard,
    EmulatedPico,
    HostBoard,
    SimulatedBoard,
    opened,
)
from tests.conformance.client import Client

TRAITS = {
    "sim": SimulatedBoard.traits,
    "host": HostBoard.traits,
    "uno": EmulatedBoard.traits,
    "mega": EmulatedBoard.traits,
    "uno-clang": EmulatedBoard.traits,
    "pico": EmulatedPico.traits,
    "pico-usb": EmulatedPico.traits,
    "device": DeviceBoard.traits,
}

# The second compiler's code takes half as long again, for which the Uno has no time while volts are
# held or a long command comes in during a run (docs/firmware.md): it is tried where neither is so.
# The Pico passes the whole suite by either link. Over USB those modules run that ask something new
# of it: bytes and frames, streams, long commands, and rates that the UART does not carry.
TRIED = {
    "uno-clang": ("configure", "fast_burst", "link", "requests", "safety", "trips", "zero"),
    "pico-usb": ("front_end", "link", "run", "small_print"),
}
EMULATED = (
    "uno",
    "mega",
    "uno-clang",
    "pico",
    "pico-usb",
)  # a processor simulated instruction by instruction


# They repeat what others show. The simulated board, the core on this computer and the Uno are put
# through every row of a test's table, the other emulated boards through the first one; and what a
# run does, and what memory keeps, is the same over the Pico's other link. What guards safety is
# tried whole on every board. The evidence tries the rest.
WHOLE = ("sim", "host", "uno", "device")
GUARDS = ("safety", "trips", "front_end", "front_end_trips", "features")
SAME_BY_USB = (
    "test_brake_stops_sooner_than_coast",
    "test_burst_drops_what_it_cannot_keep_and_says_so",
    "test_damaged_facts_keep_the_bridge_open",
    "test_encoder_reversed_negates_the_position",
    "test_reversing_negates_the_position_that_read_status_gives",
    "test_stored_facts_hold_at_once_and_after_a_reset",
)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Emulated boards take most of the time: the quick run leaves them out.

    What is repeated on several is a study.
    """
    seen = set()
    whole = set(WHOLE) - ({"device"} if config.getoption("--first-rows") else set())
    for item in items:
        board = getattr(item, "callspec", None) and item.callspec.params.get("board_name")
        if board in EMULATED:
            item.add_marker(pytest.mark.slow)
        if not board or board in whole:
            continue
        room = item.module.__name__.rpartition(".")[2].removeprefix("test_")
        test = (board, room, item.originalname)
        repeated = test in seen and room not in GUARDS
        if repeated or (board == "pico-usb" and item.originalname in SAME_BY_USB):
            item.add_marker(pytest.mark.study)
        seen.add(test)


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "needs(*traits): what a board must offer for this test")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    named = any(
        "board_name" in mark.args for mark in metafunc.definition.iter_markers("parametrize")
    )
    if named or "board_name" not in metafunc.fixturenames:
        return
    needed = {trait for mark in metafunc.definition.iter_markers("needs") for trait in mark.args}
    names = [name for name in NAMES if needed <= TRAITS[name]]
    module = metafunc.module.__name__.rpartition(".")[2].removeprefix("test_")
    names = [name for name in names if module in TRIED.get(name, (module,))]
    metafunc.parametrize("board_name", names)


@pytest.fixture
def open_board(board_name: str, request: pytest.FixtureRequest) -> Iterator[Callable[..., Board]]:
    """Opens the board under test, with options of the simulated bench where it takes them."""
    with ExitStack() as stack:
        device = request.config.getoption("--device")
        yield lambda **options: stack.enter_context(opened(board_name, device, **options))


@pytest.fixture
def board(open_board: Callable[..., Board]) -> Board:
    """The board under test as it is."""
    return open_board()


@pytest.fixture
def client(board: Board) -> Client:
    """A client of the board under test, brought up: identified, described, idle or configured."""
    return brought_up(board)


def brought_up(board: Board) -> Client:
    """A client of a board whose motor stands still: a test before may have turned it."""
    client = Client(board.port)
    client.bring_up()
    if "fresh" not in board.traits:
        client.rest()
    return client


@pytest.fixture
def make_client(open_board: Callable[..., Board]) -> Callable[..., Client]:
    """The same on a bench with options."""

    def make(**options: Any) -> Client:
        return brought_up(open_board(**options))

    return make
