"""Puts a plan in force: checked and prepared beside the control thread, then stored, then in force at once as a whole.

A plan that cannot be stored does not come into force; the old one stays, on the medium too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass

from companion.config.reversing import stern_first_refusal
from companion.core.storing import Ticket
from companion.guidance.orbit import least_radius_m
from companion.loop import Vessel
from companion.mission.plan import Adopt, PlanItem, PlanKind, PlanRefusal, PlanRefused, PlanResult, plan_id
from companion.mission.validation import check_plan

Done = Callable[[PlanRefusal | None, float], None]


@dataclass(frozen=True, slots=True)
class _Judgement:
    """What the work beside has found: why the plan is refused, or its number and how to put the rest in force."""

    refusal: PlanRefusal | None
    plan_id: int = 0
    adopt: Adopt = lambda: None


@dataclass(slots=True)
class _Change:
    """A plan on its way. `ticket`: of its storing, once that has begun. `base`: the plan that must be in force until
    then."""

    items: tuple[PlanItem, ...]
    base: tuple[PlanItem, ...] | None
    work: Future[_Judgement]
    done: Done
    ticket: Ticket | None = None


class PlanStore:
    """`put` a plan, and call `advance` until it is done. Remembers one change of each kind, and the kinds of which the
    medium may have another plan than the one in force."""

    def __init__(self, vessel: Vessel) -> None:
        self._vessel = vessel
        self._changes: dict[PlanKind, _Change] = {}
        self._astray: set[PlanKind] = set()

    def put(
        self,
        kind: PlanKind,
        items: Sequence[PlanItem],
        done: Done,
        now_s: float,
        base: tuple[PlanItem, ...] | None = None,
    ) -> None:
        """Put `items` in force, each of which has passed `check_item`; then call `done(refusal, now_s)`, at once where
        nothing takes time. `base`: the plan that they are a change of. A change that is not done ends refused."""
        overtaken = self._changes.get(kind)
        self.drop(kind)
        if overtaken is not None:
            overtaken.done(PlanRefusal(PlanResult.ERROR, "another plan came meanwhile"), now_s)
        kept = tuple(items)
        if not kept and not self._vessel.plans.items(kind):
            done(None, now_s)
            return
        self._changes[kind] = _Change(kept, base, self._vessel.worker.submit(self._judging(kind, kept, now_s)), done)
        self.advance(now_s)

    def busy(self, kind: PlanKind) -> bool:
        """Whether a plan of that kind is being checked and stored."""
        return kind in self._changes

    def drop(self, kind: PlanKind) -> None:
        """Give up a change that is not done; the plan in force stays."""
        change = self._changes.pop(kind, None)
        if change is not None:
            change.work.cancel()
            self._restore(kind)

    def advance(self, now_s: float) -> None:
        """Go on with every change as far as that takes no time."""
        for kind, change in list(self._changes.items()):
            if change.ticket is None:
                self._judge(kind, change, now_s)
            if change.ticket is not None and not change.ticket.pending and self._changes.get(kind) is change:
                self._finish(kind, change, change.ticket, now_s)

    def _judging(self, kind: PlanKind, items: tuple[PlanItem, ...], now_s: float) -> Callable[[], _Judgement]:
        """The work to do beside. What it needs of the vessel is taken now."""
        config, parameters = self._vessel.config, self._vessel.parameters
        servos, relays = len(config.servos), len(config.relays)
        least_m, takes_off = least_radius_m(parameters, config.length_m), bool(parameters["COM_TAKEOFF_OK"])
        home = self._vessel.supervisor.status(now_s).home
        at = None if home is None else (home.lat_deg, home.lon_deg)
        no_astern = stern_first_refusal(config.thrusters)
        prepare = self._vessel.plans.prepared(kind, items)

        def judge() -> _Judgement:
            refusal = check_plan(kind, items, servos, relays, least_m, takes_off, at, no_astern) if items else None
            try:
                return _Judgement(refusal) if refusal is not None else _Judgement(None, plan_id(items), prepare())
            except PlanRefused as refused:
                return _Judgement(refused.refusal)

        return judge

    def _judge(self, kind: PlanKind, change: _Change, now_s: float) -> None:
        if not change.work.done():
            return
        refusal = _outcome(change.work).refusal
        if refusal is None and change.base is not None and change.base is not self._vessel.plans.items(kind):
            refusal = PlanRefusal(PlanResult.ERROR, "the plan has changed meanwhile; load it again")
        if refusal is None:
            self._astray.add(kind)
            change.ticket = self._vessel.storage.plan(kind, change.items)
        else:
            del self._changes[kind]
            change.done(refusal, now_s)

    def _finish(self, kind: PlanKind, change: _Change, ticket: Ticket, now_s: float) -> None:
        del self._changes[kind]
        refusal = None
        if ticket.durable:
            self._astray.discard(kind)
            judgement = _outcome(change.work)
            judgement.adopt()
            self._vessel.plans.replace(kind, change.items, judgement.plan_id)
        else:
            self._restore(kind)
            result = PlanResult.NO_SPACE if ticket.full else PlanResult.ERROR
            refusal = PlanRefusal(result, f"not stored ({ticket.reason}); the old one stays in force")
        change.done(refusal, now_s)

    def _restore(self, kind: PlanKind) -> None:
        """Store the plan in force again, if another one may have reached the medium."""
        if kind in self._astray:
            self._astray.discard(kind)
            self._vessel.storage.plan(kind, self._vessel.plans.items(kind))


def _outcome(work: Future[_Judgement]) -> _Judgement:
    """The result of the work; a refusal where it failed."""
    try:
        return work.result()
    except Exception as error:  # noqa: BLE001  a plan that cannot even be judged must not stop the boat
        text = f"could not be checked ({type(error).__name__}: {error})"
        return _Judgement(PlanRefusal(PlanResult.ERROR, text))
