"""A sweep is sailed: runs are handed to workers, rows come back, whoever dies on the way."""

from __future__ import annotations

import json
import math
import shutil
import socket
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from sitl.sweep.plan import Run
from sitl.sweep.provenance import commit, versions
from sitl.sweep.rows import Row, SweepError

LOGS = "logs"
_MOST_DEATHS = 3  # of workers with the same run in hand, before the run counts as failed
_WAIT_S = 0.5


class Refused(SweepError):
    """A run that its design must not ask for: a setting has a value that the scenario does not take."""


Sail = Callable[[Run, Path], None]
"""Sails a run and leaves its result.json in the folder, as `sitl.scenarios.scenario.run` does. Raises Refused, which
ends the sweep; anything else becomes the row's error. It must be a function of a module: workers in other processes
find it by its name."""


@dataclass(frozen=True, slots=True)
class Died:
    """The worker that had a run in hand is gone, and the run with it. `last`: others died of it before."""

    key: str
    why: str
    last: bool = False


class Workers(Protocol):
    """Those who sail: processes of this machine, or of a cluster."""

    @property
    def places(self) -> int:
        """How many runs they take at a time."""
        ...

    def begin(self, key: str, run: Run) -> None:
        """Hand over a run. Raises SweepError where nobody is left to take it."""
        ...

    def finished(self, timeout_s: float) -> Sequence[Row | Died]:
        """What has ended, after waiting for the first for that time at most. Raises SweepError."""
        ...

    def close(self) -> None:
        """End them, with what they have in hand."""
        ...


def sailed(key: str, run: Run, sail: Sail, folder: Path, keep: bool = False) -> Row:
    """Sail a run with its log in `folder`/logs/`key`, which stays where the run fails, or where `keep` asks for it.
    Raises Refused."""
    log = folder / LOGS / key
    shutil.rmtree(log, ignore_errors=True)
    log.mkdir(parents=True)
    begun_s, cpu_s = time.perf_counter(), time.process_time()
    error: str | None = None
    result: Mapping[str, Any] = {}
    try:
        sail(run, log)
        result = json.loads((log / "result.json").read_text(encoding="utf-8"))
    except Refused:
        shutil.rmtree(log)
        raise
    except Exception as failure:  # noqa: BLE001  # whatever a run raises ends that run alone
        error = f"{type(failure).__name__}: {failure}"
        (log / "error.txt").write_text(traceback.format_exc(), encoding="utf-8")
    row = row_of(key, run, result, error, time.perf_counter() - begun_s)
    row = replace(row, cpu_s=time.process_time() - cpu_s)
    if row.ok and not keep:
        shutil.rmtree(log)
        return row
    return replace(row, log=f"{LOGS}/{key}")


def row_of(key: str, run: Run, result: Mapping[str, Any], error: str | None, duration_s: float) -> Row:
    """The row of a run from its result.json. `error`: why there is none."""
    checks = result.get("checks") or ()
    margins = [(_margin(check), str(check["name"])) for check in checks if not _holds_exactly(check)]
    margin, tightest = min(margins, default=(None, None))
    return Row(
        key=key,
        scenario=run.scenario,
        vessel=run.vessel,
        seed=run.seed,
        settings=dict(run.settings),
        point=run.point,
        factors=dict(run.factors),
        ok=error is None and bool(result.get("ok")),
        error=error or result.get("error"),
        failed_checks=tuple(str(check["name"]) for check in checks if not check["ok"]),
        margin=margin,
        tightest=tightest,
        metrics={name: float(v) for name, v in (result.get("metrics") or {}).items() if isinstance(v, int | float)},
        duration_s=duration_s,
        commit=commit(),
        versions=versions(),
        host=socket.gethostname(),
        faults=run.faults,
        safety={str(one["name"]): float(one["value"]) for one in result.get("margins") or ()},
    )


def _holds_exactly(check: Mapping[str, Any]) -> bool:
    """Counts and yes-or-no questions hold without any room, in every good run: that says nothing of how near it was."""
    return bool(check["ok"]) and check["value"] == check["limit"]


def _margin(check: Mapping[str, Any]) -> float:
    """How far a check is from failing, as a share of its limit; of a limit of 0, in the check's unit."""
    value, limit = float(check["value"]), float(check["limit"])
    room = (value - limit if check["at_least"] else limit - value) / (abs(limit) or 1.0)
    return room if math.isfinite(room) else math.copysign(math.inf, room) if not math.isnan(room) else -math.inf


def sail_all(
    runs: Sequence[tuple[str, Run]], workers: Workers, take: Callable[[Row], None], stopped: Callable[[str], bool]
) -> None:
    """Sail all runs, each with its key, and hand each row to `take`, once.

    A run whose worker dies is begun anew, three times at most; then its row says so. `stopped` is asked "begin" before
    each run, and "wait" while runs are sailed: True ends the one or the other. Raises SweepError.
    """
    waiting, begun, deaths = list(reversed(runs)), dict[str, Run](), dict[str, int]()
    while (waiting or begun) and not stopped("wait"):
        while waiting and len(begun) < workers.places and not stopped("begin"):
            key, run = waiting.pop()
            begun[key] = run
            workers.begin(key, run)
        if not begun:
            return
        for outcome in workers.finished(_WAIT_S):
            run = begun.pop(outcome.key)
            if isinstance(outcome, Row):
                take(_ours(outcome))
                continue
            deaths[outcome.key] = deaths.get(outcome.key, 0) + 1
            if outcome.last or deaths[outcome.key] == _MOST_DEATHS:
                take(row_of(outcome.key, run, {}, f"several workers died of it: {outcome.why}", 0.0))
            else:
                waiting.append((outcome.key, run))


def _ours(row: Row) -> Row:
    """The row. Raises SweepError where the worker has other code than we have."""
    if row.commit != commit():
        raise SweepError(f"the worker on {row.host} runs {row.commit}, and this is {commit()}: bring it up to date")
    return row
