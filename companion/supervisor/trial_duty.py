"""After a sea trial: identification beside the loop, and the operator's word on what it found.

An accepted model counts from the next start on: inertia, thrust curves and lever arms are built into controller,
allocation, gate and modes, and a boat under way that changed them all between two ticks would be in a state that nobody
has tried. MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN starts the program anew.
"""

from __future__ import annotations

import math
from concurrent.futures import Future

from companion.core.decision import ACCEPTED, ModeId, Outcome, Result, TextKind
from companion.core.events import EventLog
from companion.core.storing import Ticket
from companion.core.trial_results import TrialFinding, TrialResultError, TrialResults
from companion.params.store import Parameters
from companion.supervisor.helm import Helm

_ALIKE = 1e-3  # of a parameter: the report shows three digits


class TrialDuty:
    """`completed` after the last manoeuvre, `update` once a tick, `accept` and `undo` when an operator asks. Remembers
    the identification that runs, whether another one waits for its end, the changes that are being stored, and the
    ticket of the model that was accepted last. Set `results` before the first tick; without it nothing is identified.
    """

    def __init__(self, parameters: Parameters, helm: Helm, events: EventLog) -> None:
        self.results: TrialResults | None = None
        self._parameters = parameters
        self._helm = helm
        self._events = events
        self._runs: Future[TrialFinding] | None = None
        self._waits = False
        self._storing: list[tuple[Ticket, str]] = []
        self._accepted: Ticket | None = None  # until it is undone, or another model is found

    @property
    def identifying(self) -> bool:
        """Whether an identification runs."""
        return self._runs is not None

    def completed(self, now_s: float) -> None:
        """A trial is complete: identify, if need be after the one before."""
        self._waits = self._runs is not None
        if self.results is None or self._waits:
            return
        self._runs = self.results.identify()
        self._events.say(now_s, TextKind.ROUTINE, "trial_identifying", "Trial: identifying the boat from the log")

    def update(self, now_s: float) -> None:
        """Tell what is done."""
        if self._runs is not None and self._runs.done():
            self._conclude(self._runs, now_s)
            self._runs = None
            if self._waits:
                self.completed(now_s)
        for ticket, text in [one for one in self._storing if not one[0].pending]:
            self._storing.remove((ticket, text))
            if ticket.durable:
                self._events.say(now_s, TextKind.ROUTINE, "trial_decided", text)
                for kept in self.kept():
                    self._events.say(now_s, TextKind.ATTENTION, "trial_parameter", kept)
            else:
                failed = f"Trial: nothing changed: {ticket.reason}"
                self._events.say(now_s, TextKind.ALARM, "trial_not_stored", failed)

    def _conclude(self, runs: Future[TrialFinding], now_s: float) -> None:
        try:
            found = runs.result()
        except TrialResultError as error:
            self._events.say(now_s, TextKind.ATTENTION, "trial_unidentified", f"Trial: not identified: {error}")
            return
        except Exception as error:  # noqa: BLE001  whatever went wrong beside the loop, the boat sails on
            text = f"Trial: not identified ({type(error).__name__})"
            self._events.say(now_s, TextKind.ATTENTION, "trial_unidentified", text)
            return
        self._accepted = None
        share = "" if found.error_share is None else f", error {found.error_share:.0%} of before"
        if found.better:
            text = f"Trial: new model{share}. Accept it?"
        else:
            text = "Trial: the model stays, new gains. Accept them?"
        self._events.say(now_s, TextKind.ATTENTION, "trial_identified", text)

    def kept(self) -> list[str]:
        """One line for each parameter that an operator has set otherwise than the accepted models: it stays so."""
        found = {} if self.results is None else self.results.parameters
        own = self._parameters.changed()
        return [
            f"{name} stays {own[name]:.3g} as set; trial: {value:.3g}"
            for name, value in found.items()
            if name in own and not math.isclose(own[name], value, rel_tol=_ALIKE)
        ]

    # --- the operator's word -----------------------------------------------------------------------------------------

    def accept(self, now_s: float) -> tuple[Outcome, Ticket | None]:
        """Accept the newest model: (outcome, what is being stored). Disarmed or in Hold only. One that is accepted
        stays so: who has lost the acknowledgement asks again."""
        results = self.results
        if self._accepted is not None and not self._accepted.failed and not self.identifying:
            return ACCEPTED, self._accepted
        reason = self._not_now() or ("no trial result waits" if results is None or results.proposal is None else None)
        if reason is not None or results is None:
            return self._refused("Trial accept", reason or "", now_s), None
        self._accepted = results.accept()
        return self._store(self._accepted, "Trial: accepted; reboot to use the new model")

    def undo(self, now_s: float) -> tuple[Outcome, Ticket | None]:
        """Go back to the model before: (outcome, what is being stored). Disarmed or in Hold only."""
        results = self.results
        reason = self._not_now() or ("the file counts already" if results is None or results.in_force is None else None)
        if reason is not None or results is None:
            return self._refused("Trial undo", reason or "", now_s), None
        self._accepted = None
        return self._store(results.undo(), "Trial: undone; reboot to use the model before")

    def _not_now(self) -> str | None:
        calm = not self._helm.armed or self._helm.mode.id is ModeId.HOLD
        if not calm:
            return "disarm or choose Hold"
        return "still identifying" if self.identifying else None

    def _refused(self, what: str, reason: str, now_s: float) -> Outcome:
        text = f"{what} refused: {reason}"
        self._events.say(now_s, TextKind.REFUSAL, "refused", text)
        return Outcome(Result.TEMPORARILY_REJECTED, text)

    def _store(self, ticket: Ticket, text: str) -> tuple[Outcome, Ticket]:
        self._storing.append((ticket, text))
        return ACCEPTED, ticket
