"""All that a vessel writes to its medium, as the rest of it sees that: tickets, warnings and health."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.core.storing import Ticket, durable
from companion.core.tick import STORAGE, DeviceHealth, Tick
from companion.mission.plan import PlanItem, PlanKind
from companion.params.store import Parameters
from companion.record.log_writer import LogOutput
from companion.record.progress_keeper import ProgressKeeper
from companion.record.state_file import StateFile
from companion.record.writer import RETRY_S

REMIND_S = 300.0
SLOW_S = 3.0  # for one small file


def log_health(log: LogOutput) -> DeviceHealth:
    """The health of a log."""
    return DeviceHealth("log", log.stopped is None, None, "" if log.stopped is None else f"stopped: {log.stopped}")


class BoatStorage:
    """Implements `core.ports.Storage` and, as a recorder, watches the writers once a tick.

    Remembers the parameters as last submitted, and what was announced of the log.
    """

    def __init__(
        self,
        state: StateFile | None,
        parameters: Parameters,
        keeper: ProgressKeeper | None,
        log: LogOutput | None,
        say: Announce,
    ) -> None:
        """`state`, `keeper`: None where nothing is stored over a restart; `log`: None where nothing is logged."""
        self._state = state
        self._keeper = keeper
        self._watch = None if log is None else LogWatch(log, say)
        self._values: dict[str, float] = parameters.changed()
        self._ticket = durable()
        self._parameters = parameters
        self._at_work: object | None = None
        self._since_s = self._retried_s = 0.0
        if state is not None:
            parameters.after_change(partial(self._save_parameters, state))

    def _save_parameters(self, state: StateFile) -> None:
        values = self._parameters.changed()
        if values != self._values:
            self._values = values
            self._ticket = state.save_parameters(values)

    def parameters(self) -> Ticket:
        """As `Storage.parameters`."""
        return self._ticket

    def progress(self) -> Ticket:
        """As `Storage.progress`."""
        return durable() if self._keeper is None else self._keeper.save()

    def plan(self, kind: int, items: Sequence[PlanItem]) -> Ticket:
        """As `Storage.plan`."""
        return durable() if self._state is None else self._state.save_plan(PlanKind(kind), items)

    def health(self, now_s: float) -> Sequence[DeviceHealth]:
        """As `Storage.health`: one item for the state and the log together."""
        faults = [] if self._state is None else [self._state.writer.failing, self._slow(now_s)]
        if self._watch is not None:
            faults.append(self._watch.fault)
        text = "; ".join(fault for fault in faults if fault)
        return (DeviceHealth(STORAGE, not text, None, text),)

    def lost(self) -> Sequence[str]:
        """As `Storage.lost`."""
        return () if self._state is None else self._state.lost

    def record(self, tick: Tick) -> None:
        """Pass on what the writers have met with, and let them try again."""
        if self._state is not None:
            writer = self._state.writer
            if tick.t_s - self._retried_s >= RETRY_S:
                self._retried_s = tick.t_s
                writer.retry()
            if writer.at_work is not self._at_work:
                self._at_work, self._since_s = writer.at_work, tick.t_s
            self._state.tell_news()
        if self._watch is not None:
            self._watch.update(tick.t_s)

    def close(self) -> None:
        """Write what waits."""
        if self._state is not None:
            self._state.writer.close()
            self._state.tell_news()

    def _slow(self, now_s: float) -> str:
        waited_s = 0.0 if self._at_work is None else now_s - self._since_s
        return f"the medium has been busy for {waited_s:.0f} s" if waited_s >= SLOW_S else ""


class LogWatch:
    """Announces that the log stops, goes on or loses rows. Call `update` once a tick."""

    def __init__(self, log: LogOutput, say: Announce) -> None:
        self._log = log
        self._say = say
        self._number = log.number
        self._stopped: str | None = None
        self._lost_bytes = 0
        self._told_s = 0.0

    @property
    def fault(self) -> str:
        """Why nothing is logged now; empty while all is."""
        return "" if self._log.stopped is None else f"log stopped: {self._log.stopped}"

    def update(self, now_s: float) -> None:
        """Announce what has changed, and remind every five minutes of a log that is stopped."""
        log = self._log
        if log.stopped is not None and (log.stopped != self._stopped or now_s - self._told_s >= REMIND_S):
            self._tell(now_s, TextKind.ATTENTION, f"Log stopped: {log.stopped}")
        elif log.number != self._number:
            self._tell(now_s, TextKind.ROUTINE, f"Log goes on in {log.folder.name}")
        elif log.stopped is None and log.lost_bytes > self._lost_bytes and now_s - self._told_s >= REMIND_S:
            self._tell(now_s, TextKind.ATTENTION, "Log has gaps: the medium is too slow")
        self._number, self._stopped = log.number, log.stopped

    def _tell(self, now_s: float, kind: TextKind, text: str) -> None:
        self._told_s, self._lost_bytes = now_s, self._log.lost_bytes
        self._say(now_s, kind, "log", text)
