"""Many stations, one PostgreSQL, one broker, one store, random kills of all: what is lost?

    python bench/bench_plant.py [--stations 20] [--inspections 100] [--replay 100000] [--every 8]

Each station inspects motors on a simulated board in a process of its own, ordered by a line
controller. About each EVERY seconds a station, the database or the broker is killed (SIGKILL), the
broker hangs, or the store refuses connections; it comes back after a drawn time. A consumer
acknowledges verdicts over MQTT.

In the end each verdict on a station's disk must be in the database once and with the consumer once,
as it was shown; the seals must hold, with every mark that an inspection keeps; each motor must be
judged; each result must lead to its capture's file, by SHA-256, and each capture back; the store
must hold each capture and verdict, byte by byte, and nothing else. Then REPLAY results are added by
reference to these captures, by a writer for each station, and a cluster whose workers are killed
fits each capture out of the store. Ends with 1 where anything is lost or doubled.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.plant.refit import refitted
from bench.plant.replay import replay
from bench.plant.services import Broker, Database, ObjectStore
from bench.plant.station import Station
from motorid.quality.history import History, open_history
from motorid.workflow import shift_history, spool, uploads
from motorid.workflow.check import CAPTURE, VERDICT
from motorid.workflow.mqtt import outbox
from motorid.workflow.shift_history import anchors
from tests.plant.consumer import Consumer, consuming
from tests.storage.stores import ENVIRONMENT

MARKS = (shift_history.MARK, outbox.MARK, uploads.MARK)
BUCKET = "plant"
AWAY_S = 6.0  # at most
HANG, STATION, DATABASE, BROKER, STORE = "broker hangs", "station", "database", "broker", "store"
SHARES = {STATION: 0.5, DATABASE: 0.15, BROKER: 0.1, HANG: 0.1, STORE: 0.15}


def trouble(
    stations: Sequence[Station],
    database: Database,
    broker: Broker,
    store: ObjectStore,
    every_s: float,
) -> Counter[str]:
    """Kills until every station is through; how often what."""
    rng, done = np.random.default_rng(2029), Counter[str]()
    while any(one.is_alive() for one in stations):
        time.sleep(rng.exponential(every_s))
        what, away_s = (
            str(rng.choice(list(SHARES), p=list(SHARES.values()))),
            rng.uniform(0, AWAY_S),
        )
        done[what] += 1
        match what:
            case "station":
                stations[int(rng.integers(len(stations)))].kill()
            case "broker hangs":
                broker.signal(signal.SIGSTOP)
                time.sleep(away_s)
                broker.signal(signal.SIGCONT)
            case _:
                service = {DATABASE: database, BROKER: broker, STORE: store}[what]
                service.fail()
                time.sleep(away_s)
                service.start()
    return done


def verdicts(folder: Path) -> dict[str, dict[str, Any]]:
    """Every verdict on the stations' disks, by its key."""
    found = {}
    for path in folder.glob(f"line-*/*/{VERDICT}"):
        stored = json.loads(path.read_text(encoding="utf-8"))
        found[stored["content_sha256"]] = stored
    return found


def lost_or_doubled(
    disk: dict[str, dict[str, Any]], history: History, consumer: Consumer, folder: Path
) -> Iterator[str]:
    """Disk, database and consumer against each other."""
    said = Counter(
        (v["serial"], v["outcome"], v.get("station", ""), datetime.fromisoformat(v["time"]))
        for v in disk.values()
    )
    rows = Counter((r.serial, r.outcome, r.station, r.at) for r in history.results())
    yield from (f"on disk and not in the database: {one}" for one in said - rows)
    yield from (f"in the database and not on disk, or twice: {one}" for one in rows - said)
    yield from (f"not with the consumer: {one[:12]}" for one in disk.keys() - consumer.verdicts)
    yield from (f"with the consumer alone: {one[:12]}" for one in consumer.verdicts.keys() - disk)
    yield from (f"another one with the consumer: {k[:12]}" for k in disk
                if consumer.verdicts.get(k, disk[k]) != disk[k])  # fmt: skip
    checked = history.verify([head for one in folder.glob("line-*") for head in anchors(one)])
    yield from checked.problems


def untraceable(history: History, folder: Path) -> Iterator[str]:
    """Results that do not lead to a raw capture on a station's disk; captures without a result."""
    files = {_sha256(path): path for path in folder.glob(f"line-*/*/{CAPTURE}")}
    cited = set()
    for row in history.results():
        for capture in history.captures_of(row.id):
            cited.add(capture.sha256)
            if capture.sha256 not in files:
                yield f"result {row.id} cites a capture that is no file: {capture.sha256[:12]}"
            if row.id not in [one.id for one in history.results_of(capture.sha256)]:
                yield f"capture {capture.sha256[:12]} does not lead back to result {row.id}"
    yield from (f"{files[one]} is cited by no result" for one in files.keys() - cited)


def stored_otherwise(store: ObjectStore, folder: Path) -> Iterator[str]:
    """Where the store does not hold what the stations' disks do."""
    names = (CAPTURE, VERDICT)
    disk = {
        path.relative_to(folder).as_posix(): _sha256(path)
        for path in folder.glob("line-*/*/*")
        if path.name in names and (path.parent / VERDICT).exists()
    }
    held = {k: v for k, v in store.digests(BUCKET).items() if k.rpartition("/")[2] in names}
    yield from (f"not in the store: {one}" for one in disk.keys() - held)
    yield from (f"in the store alone: {one}" for one in held.keys() - disk)
    yield from (f"other bytes in the store: {k}" for k in disk.keys() & held if disk[k] != held[k])


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def shift(options: argparse.Namespace, folder: Path, stack: contextlib.ExitStack) -> list[str]:
    """The whole of it; what is wrong, in sentences."""
    database, broker = Database(folder / "pg"), Broker(folder)
    database.start()
    stack.callback(database.stop)
    broker.start()
    stack.callback(broker.kill)
    store = ObjectStore()
    stack.callback(store.kill)
    store.bucket(BUCKET)
    os.environ |= {**ENVIRONMENT, "AWS_ENDPOINT_URL": store.address, spool.FOLDER: str(folder)}
    shifts_of = folder / "s3" / BUCKET  # where the spool has the stations' inspections
    open_history(database.url).close()
    settings = folder / "mqtt.toml"
    settings.write_text(
        f'url = "mqtt://127.0.0.1:{broker.port}"\nacknowledged = true\nrepeat_s = 5\n'
    )
    consumer = stack.enter_context(consuming(broker.port))
    shared = ["--history", database.url, "--mqtt", str(settings)]
    stations = [
        Station(f"line-{n:02d}", shifts_of / f"line-{n:02d}", f"s3://{BUCKET}/line-{n:02d}", shared,
                [f"D{n:02d}{k:04d}" for k in range(options.inspections)])
        for n in range(options.stations)
    ]  # fmt: skip
    for one in stations:
        stack.callback(one.end_process)
        one.start()
    began = time.monotonic()
    kinds = trouble(stations, database, broker, store, options.every)
    worked_s = time.monotonic() - began
    wrong = [one.failed for one in stations if one.failed]
    for one in stations:
        wrong += one.finish(MARKS)
    disk = verdicts(shifts_of)
    with open_history(database.url) as history:
        wrong += lost_or_doubled(disk, history, consumer, shifts_of)
        wrong += untraceable(history, shifts_of)
    wrong += stored_otherwise(store, shifts_of)
    judged = {v["serial"] for v in disk.values() if v["outcome"] != "INVALID"}
    wrong += [f"never judged: {s}" for one in stations for s in one.serials if s not in judged]
    outcomes = Counter(v["outcome"] for v in disk.values())
    print(f"{options.stations} stations, {len(judged)} motors in {worked_s:.0f} s; "
          f"verdicts: {dict(sorted(outcomes.items()))}")  # fmt: skip
    shifts, orders = sum(s.shifts for s in stations), sum(s.accepted for s in stations)
    print(
        f"killed or hung: {dict(sorted(kinds.items()))}; {shifts} shifts, {orders} orders accepted"
    )
    print(f"the consumer got {len(consumer.came)} messages for {len(disk)} verdicts")
    if options.replay and not wrong:
        wrong += replayed(options, database, shifts_of)
    wrong += refitted(
        f"s3://{BUCKET}", folder / "fits", len(list(shifts_of.glob(f"*/*/{CAPTURE}")))
    )
    return wrong


def replayed(options: argparse.Namespace, database: Database, folder: Path) -> Iterator[str]:
    """Results by reference: how fast, in how much memory, and whether all are there."""
    folders = [one.parent for one in sorted(folder.glob(f"line-*/*/{CAPTURE}"))]
    with open_history(database.url) as history:
        before = history.count()
    seconds, done = replay(database.url, folders, options.replay, options.stations)
    count = sum(one.count for one in done)
    grown = max(one.late_mb - one.early_mb for one in done)
    print(f"{count} results by reference from {len(done)} writers in {seconds:.1f} s: "
          f"{count / seconds:.0f} a second; after its first tenth a writer grew by {grown:.1f} MB "
          f"at most, to {max(one.late_mb for one in done):.0f} MB")  # fmt: skip
    with open_history(database.url) as history:
        if history.count() != before + count or count != options.replay // len(done) * len(done):
            yield f"{history.count() - before} of {options.replay} replayed results are there"
        yield from history.verify().problems


def main() -> int:
    """1 where anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--stations", type=int, default=20)
    parser.add_argument("--inspections", type=int, default=100, help="motors of each station")
    parser.add_argument("--replay", type=int, default=100_000)
    parser.add_argument(
        "--every", type=float, default=8.0, help="seconds between kills, in the mean"
    )
    options = parser.parse_args()
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="motorid-plant-")))
        folder.chmod(0o755)  # the database has a user of its own
        wrong = shift(options, folder, stack)
    print("\n".join(wrong))
    print(f"{len(wrong)} faults")
    return min(len(wrong), 1)


if __name__ == "__main__":
    sys.exit(main())
