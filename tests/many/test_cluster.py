"""Tasks on a real Dask cluster of this machine: same results, and what dies costs nothing else."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import distributed
import pytest

from motorid.cli.main import run
from motorid.errors import DataError, LinkError, UsageError
from motorid.quality.history import Query, open_history
from motorid.quality.product import load_product
from motorid.workflow import cluster
from motorid.workflow import rejudge as rejudging
from motorid.workflow.many import fit_many, table
from motorid.workflow.rejudge import judge_into, rejudge
from motorid.workflow.task import Result, Task
from motorid.workflow.tasks import run_all
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.many.cluster_tasks import broken, deadly, gated, plain, surroundings

Cluster = Any


@pytest.fixture(scope="module")
def threads() -> Iterator[Cluster]:
    """A scheduler and two workers as threads of this process, spoken to over TCP."""
    with local() as found:
        yield found


def local(**options: Any) -> Cluster:
    chosen = {"n_workers": 2, "processes": False, "protocol": "tcp://", **options}
    return distributed.LocalCluster(threads_per_worker=1, dashboard_address="127.0.0.1:0", **chosen)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        number: int = taken.getsockname()[1]
    return number


def tasks_of(work: Callable[..., Result], *more: Any, count: int = 5) -> list[Task]:
    return [Task(work, (n, *more), {"work": work.__name__, "n": n}) for n in range(count)]


def captures(folder: Path) -> list[Path]:
    from motorid.capture import store

    plan = Plan(volts=(6.0, 3.0))
    paths = [folder / f"{seed}.h5" for seed in range(2)]
    for seed, path in enumerate(paths):
        store.save(noisy(clean_capture(FAULHABER, plan), seed, 1e-3, 1e-4), path)
    (folder / "torn.h5").write_bytes(paths[0].read_bytes()[:3000])
    return [*paths, folder / "torn.h5", folder / "absent.h5"]


@pytest.mark.slow
def test_fits_are_those_of_one_process_to_the_last_digit(threads: Cluster, tmp_path: Path) -> None:
    paths = captures(tmp_path)
    seen: list[tuple[int, int]] = []
    alone = fit_many(paths, tmp_path / "alone", model="six")
    far = fit_many(
        paths,
        tmp_path / "far",
        model="six",
        jobs=threads.scheduler_address,
        progress=lambda done, total: seen.append((done, total)),
    )
    assert table(far) == table(alone)
    assert [bool(fit.failure) for fit in far] == [False, False, True, True]
    assert seen == [(0, 3), (1, 3), (2, 3), (3, 3)]
    # what was fitted is kept, and what could not be read may be read another time
    assert len(list((tmp_path / "far" / "runs").iterdir())) == 2
    assert fit_many(paths[:2], tmp_path / "far", model="six", jobs="tcp://127.0.0.1:1") == far[:2]


@pytest.mark.slow
def test_old_captures_are_judged_again_and_an_interrupted_run_goes_on(
    threads: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Same results as one process, one of them done before; what is done is not fitted again."""
    product = load_product("sim-disc")
    places = captures(tmp_path)[:2]
    tables = []
    for name, jobs in (("near", 1), ("far", threads.scheduler_address)):
        with open_history(tmp_path / f"{name}.db") as history:
            assert all(one.new for one in judge_into(history, product, places))
            first = rejudge(history, product, Query(), jobs=1)
            assert next(first).new  # then it is interrupted
            first.close()
            found = list(rejudge(history, product, Query(kind="check"), jobs=jobs))
            assert sorted(one.new for one in found) == [False, True]
            assert {(one.before, one.after) for one in found} == {("INVALID", "INVALID")}
            monkeypatch.setattr(rejudging, "_judged", broken)  # nothing is left to be fitted
            again = list(rejudge(history, product, Query(kind="check"), jobs=jobs))
            assert [one.new for one in again] == [False, False]
            monkeypatch.undo()
            tables.append(sorted((r.serial, r.kind, r.key) for r in history.results()))
    assert tables[0] == tables[1]
    assert len(tables[0]) == 4


def test_only_paths_travel_and_never_what_is_in_the_files() -> None:
    deep = (Path("a.h5"), (Path("b.h5"), 3), "text")
    first, (second, number), text = cluster._absolute(deep)
    assert first == Path("a.h5").absolute()
    assert second.is_absolute()
    assert (number, text) == (3, "text")


@pytest.mark.slow
def test_a_worker_that_dies_costs_its_task_alone(tmp_path: Path) -> None:
    tasks = tasks_of(plain, count=4)
    tasks.append(Task(deadly, (81, tmp_path / "died"), {"dies": "once"}))
    said: Callable[[str], Result] = lambda says: {"root": -1.0, "failure": says}  # noqa: E731
    tasks.append(Task(deadly, (9,), {"dies": "always"}, said))
    with local(n_workers=1, processes=True, silence_logs=50) as small:
        small.scheduler.allowed_failures = 0
        found = run_all(tasks, tmp_path / "runs", small.scheduler_address)
        assert [one["root"] for one in found] == [0.0, 1.0, 2**0.5, 3**0.5, 9.0, -1.0]
        assert "died" in found[-1]["failure"]
    assert len(list((tmp_path / "runs").iterdir())) == 5  # that one is tried again another time


@pytest.mark.slow
def test_a_scheduler_that_restarts_costs_what_was_not_answered_alone(tmp_path: Path) -> None:
    port, gate = free_port(), tmp_path / "gate"
    tasks = [*tasks_of(plain, count=2), *tasks_of(gated, gate, count=3)]
    benches = [local(n_workers=1, scheduler_port=port)]

    def restart(done: int, total: int) -> None:
        if done == 2 and len(benches) == 1:  # both plain ones, by the only worker
            gate.touch()  # else closing waits for the worker
            benches[0].close()
            benches.append(local(n_workers=1, scheduler_port=port))

    try:
        found = run_all(tasks, tmp_path / "runs", f"tcp://127.0.0.1:{port}", restart)
    finally:
        gate.touch()
        for bench in benches:
            bench.close()
    assert len(benches) == 2
    assert [one["root"] for one in found] == [0.0, 1.0, 0.0, 1.0, 2**0.5]


@pytest.mark.slow
def test_a_cluster_without_a_worker_is_said_and_not_waited_for(tmp_path: Path) -> None:
    with local(n_workers=0) as empty:
        tasks = {tmp_path / "a": tasks_of(plain)[0]}
        with pytest.raises(LinkError, match=r"no worker for 0.2 s.*0 of 1 are done and kept"):
            list(cluster.answered(tasks, empty.scheduler_address, patience_s=0.2))


@pytest.mark.slow
def test_nobody_at_the_address_is_said(tmp_path: Path) -> None:
    tasks = {tmp_path / "a": tasks_of(plain)[0]}
    with pytest.raises(LinkError, match=r"no Dask scheduler answers .* 0 of 1 are done"):
        list(cluster.answered(tasks, f"tcp://127.0.0.1:{free_port()}", patience_s=0.1))


@pytest.mark.slow
def test_a_defect_of_a_task_is_named(threads: Cluster, tmp_path: Path) -> None:
    with pytest.raises(DataError, match="a task of the cluster failed: ZeroDivisionError: 0"):
        run_all(tasks_of(broken, count=1), tmp_path / "runs", threads.scheduler_address)


@pytest.mark.slow
def test_more_tasks_than_the_window_are_sent_as_others_finish(
    threads: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "WINDOW", 3)
    found = run_all(tasks_of(plain, count=20), tmp_path / "runs", threads.scheduler_address)
    assert [one["root"] for one in found] == [n**0.5 for n in range(20)]


def test_a_worker_of_another_version_is_refused() -> None:
    with pytest.raises(UsageError, match="a worker of the cluster has motorid"):
        cluster._remote(plain, (1,), "0.0.0")


@pytest.mark.parametrize(
    "address", ["", "local", "local:", "local:0", "local:x", "tcp://", "tcp://host", "host:8786"]
)
def test_what_is_no_address_is_refused(address: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(UsageError, match="write tcp://HOST:PORT"):
        cluster.check_address(address)
    assert run(["fit", "x.h5", "--cluster", address or " ", "-o", "out"]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_without_dask_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(UsageError, match=r"pip install 'motorid\[plant\]'"):
        run_all(tasks_of(plain), tmp_path / "runs", "local:1")


@pytest.mark.slow
def test_workers_of_this_computer_compute_on_one_core_and_watch_themselves_little(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Dask's own settings are as before for whoever else uses it."""
    import dask

    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    monkeypatch.delenv("MALLOC_TRIM_THRESHOLD_", raising=False)
    before = dask.config.get("distributed.nanny.pre-spawn-environ")
    answers = run_all(tasks_of(surroundings, count=20), tmp_path / "runs", "local:1")
    found = answers[0]
    assert len({one["process"] for one in answers}) == 1, "as many workers as were asked for"
    assert found["OPENBLAS_NUM_THREADS"] == "1"
    assert found["MALLOC_TRIM_THRESHOLD_"] is None
    assert found["profiled"] is False
    assert dask.config.get("distributed.nanny.pre-spawn-environ") == before
    assert dask.config.get("distributed.worker.profile.enabled")


def test_processes_that_do_not_start_are_said_in_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker that is killed before it answers; no computer is short of memory on purpose."""

    def failing(*_: Any, **__: Any) -> None:
        raise RuntimeError("Nanny failed to start.")

    monkeypatch.setattr(distributed, "LocalCluster", failing)
    with pytest.raises(LinkError, match=r"its processes did not start .*: give the same command"):
        run_all(tasks_of(plain), tmp_path / "runs", "local:1")
