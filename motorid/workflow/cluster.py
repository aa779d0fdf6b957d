"""Tasks on a Dask cluster: sent by reference, answered as they finish, whatever dies meanwhile.

Dask's futures hold nothing that lasts: a scheduler that restarts cancels them, finished ones too.
So each answer is kept by the caller at once, and what has none is sent again. joblib's own Dask
backend was tried first: one task whose worker dies ends all the others with it.
"""

from __future__ import annotations

import contextlib
import logging
import os
import time
from collections.abc import Callable, Hashable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from motorid.errors import LinkError, UsageError
from motorid.storage.place import Member
from motorid.version import __version__

if TYPE_CHECKING:
    from motorid.workflow.task import Result, Task

Key = TypeVar("Key", bound=Hashable)
LOCAL = "local:"
SCHEMES = ("tcp://", "tls://")
WINDOW = 2000  # tasks that the scheduler holds at a time: memory stays flat over millions
PATIENCE_S = 60.0  # for a scheduler that restarts, and for a first worker
CONNECT_S = 5.0  # for one attempt
POLL_S = 0.05
IDLE = 5  # attempts in turn in which nothing was answered
LOOK_S = 1.0  # between looks for workers
LEAN = {  # Dask's own settings, less what takes a fifth of a worker from fits
    "distributed.worker.profile.enabled": False,  # looks at the stack a hundred times a second
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.nanny.pre-spawn-environ": {  # and no MALLOC_TRIM_THRESHOLD_: each fit would page
        "OMP_NUM_THREADS": 1,
        "MKL_NUM_THREADS": 1,
        "OPENBLAS_NUM_THREADS": 1,
    },
}


def check_address(address: str) -> str:
    """``address`` where it is one: tcp://HOST:PORT, tls://HOST:PORT or local:N. Else UsageError."""
    host, _, number = address.rpartition(":")
    if address.startswith(LOCAL):
        if number.isdecimal() and 0 < int(number) <= 1024:
            return address
    elif address.startswith(SCHEMES) and host.partition("://")[2] and number.isdecimal():
        return address
    raise UsageError(
        f"--cluster {address}: write tcp://HOST:PORT of a Dask scheduler, or local:N for "
        "N processes"
    )


def answered(
    missing: Mapping[Key, Task], address: str, patience_s: float = PATIENCE_S
) -> Iterator[tuple[Key, Result | Failure]]:
    """Each task's key with its Result, or with why there is none, in the order they finish.

    A task whose worker died is tried once more, alone. Raises UsageError without Dask, LinkError
    where the cluster cannot be reached, or is lost for ``patience_s``; what was answered until
    then was yielded.
    """
    left: dict[Key, Task] = dict(missing)
    suspects: dict[Key, Task] = {}
    idle = 0
    with _cluster(address) as where:
        while left or suspects:
            alone = not left
            batch = left if left else dict([next(iter(suspects.items()))])
            before = len(left) + len(suspects)
            try:
                with _client(where, patience_s) as client:
                    for key, found in _round(client, batch, patience_s):
                        task = (suspects if alone else left).pop(key)
                        if isinstance(found, Failure) and found.died and not alone:
                            suspects[key] = task
                        else:
                            yield key, found
            except _lost():
                pass  # what is left is sent again, once a scheduler answers
            except LinkError as error:
                done = len(missing) - len(left) - len(suspects)
                raise LinkError(
                    f"{error}; {done} of {len(missing)} are done and kept: give the same command "
                    "again"
                ) from None
            idle = idle + 1 if len(left) + len(suspects) == before and not suspects else 0
            if idle > IDLE:
                raise LinkError(f"{address}: the cluster is lost again and again: see its own logs")


class Failure:
    """Why a task has no Result; ``died``: its worker did."""

    def __init__(self, says: str, died: bool = False) -> None:
        self.says, self.died = says, died


def _round(
    client: Any, left: Mapping[Key, Task], patience_s: float
) -> Iterator[tuple[Key, Result | Failure]]:
    """One attempt at all that is left. Ends early where the scheduler forgot its futures."""
    distributed: Any = import_module("distributed")
    waiting = iter(list(left.items()))
    keys: dict[Any, Key] = {}
    finished = distributed.as_completed(loop=client.loop)

    def send(count: int) -> None:
        for key, task in (pair for pair, _ in zip(waiting, range(count), strict=False)):
            future = client.submit(
                _remote, task.work, _absolute(task.arguments), __version__, pure=False
            )
            keys[future] = key
            finished.add(future)

    send(WINDOW)
    looked = alive = time.monotonic()
    while keys:
        batch = finished.next_batch(block=False)
        for future in batch:
            key = keys.pop(future)
            if future.status not in ("cancelled", "lost"):  # else another round sends it again
                yield key, _of(future)
        send(len(batch))
        if batch:
            continue
        time.sleep(POLL_S)
        now = time.monotonic()
        if now - looked < LOOK_S:
            continue
        looked = now
        if client.nthreads():
            alive = now
        elif now - alive > patience_s:
            raise LinkError(f"the cluster has had no worker for {patience_s:g} s: start one")


def _of(future: Any) -> Result | Failure:
    """What became of one task."""
    error = future.exception()
    if error is None:
        result: Result = future.result()
        return result
    if type(error).__name__ == "KilledWorker":
        return Failure("each worker that computed it died", died=True)
    if isinstance(error, UsageError):
        raise error
    return Failure(f"{type(error).__name__}: {error}")


def _remote(work: Callable[..., Result], arguments: tuple[Any, ...], version: str) -> Result:
    """Runs on a worker. Raises UsageError where that has another motorid."""
    from motorid import json_text

    if version != __version__:
        raise UsageError(
            f"a worker of the cluster has motorid {__version__}, and {version} asks: "
            "install the same"
        )
    found: Result = json_text.plain(work(*arguments))
    return found


def _absolute(arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """Paths as another process finds them, from whatever folder it was started in."""
    return tuple(map(_anywhere, arguments))


def _anywhere(one: Any) -> Any:
    if isinstance(one, Path):
        return Path(os.path.abspath(one))
    if isinstance(one, Member):
        return Member(_anywhere(one.pack), one.inner)
    return _absolute(one) if isinstance(one, tuple) else one


@contextlib.contextmanager
def _cluster(address: str) -> Iterator[str]:
    """The scheduler's address; of a cluster of this machine where ``local:N`` asks for one."""
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise UsageError("--cluster needs Dask: pip install 'motorid[plant]'") from None
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] in ("distributed", "tornado"):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # what matters is said by the caller
    if not address.startswith(LOCAL):
        yield address
        return
    options = {
        "n_workers": int(address.removeprefix(LOCAL)),
        "threads_per_worker": 1,
        "dashboard_address": "127.0.0.1:0",
        "silence_logs": logging.CRITICAL,
    }
    with import_module("dask").config.set(LEAN):
        try:
            cluster = distributed.LocalCluster(**options)
        except (RuntimeError, OSError, TimeoutError) as error:
            raise LinkError(
                f"{address}: its processes did not start ({error}): give the same command again"
            ) from None
        with cluster:
            yield str(cluster.scheduler_address)


@contextlib.contextmanager
def _client(address: str, patience_s: float) -> Iterator[Any]:
    """A client of the scheduler, once it answers. Raises LinkError where it does not."""
    distributed: Any = import_module("distributed")
    until = time.monotonic() + patience_s
    while True:
        try:
            client = distributed.Client(
                address, timeout=min(CONNECT_S, patience_s), set_as_default=False
            )
            break
        except (OSError, TimeoutError) as error:
            if time.monotonic() > until:
                raise LinkError(
                    f"{address}: no Dask scheduler answers ({type(error).__name__}): is it "
                    "running, and the address right?"
                ) from None
            time.sleep(POLL_S)
    try:
        yield client
    finally:
        with contextlib.suppress(OSError, TimeoutError):
            client.close(timeout=CONNECT_S)


def _lost() -> tuple[type[BaseException], ...]:
    return (OSError, TimeoutError, import_module("distributed").comm.CommClosedError)
