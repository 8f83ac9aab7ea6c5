"""After a sea trial: identification beside the loop, and the operator's word on it."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any

import pytest

from companion.core.decision import ModeId, Severity
from companion.core.storing import Stored
from companion.core.trial_results import TrialFinding, TrialResultError
from companion.modes.trial.mode import COMPLETE, TrialMode, TrialOrder
from tests.trials import KnownTrials
from tests.unit.conftest import Boat
from tests.unit.modes.test_circle import armed


def trials_of(boat: Boat, trials: KnownTrials) -> KnownTrials:
    boat.supervisor.trial_duty.results = trials
    return trials


def completed(boat: Boat, monkeypatch: pytest.MonkeyPatch, how: str = COMPLETE) -> None:
    armed(boat)
    assert boat.supervisor.give_order(TrialOrder(), boat.now_s).accepted
    boat.step()
    with monkeypatch.context() as patch:
        patch.setattr(TrialMode, "ended", how)
        boat.step(0.2)


def test_a_complete_trial_is_identified_and_the_finding_told(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    trials = trials_of(boat, KnownTrials())
    completed(boat, monkeypatch)
    boat.step(5.0)
    assert trials.done == ["identify"] and boat.status.mode is ModeId.HOLD
    trials.runs.set_result(TrialFinding(True, 0.31))
    boat.step()
    assert "Trial: new model, error 31% of before. Accept it?" in boat.texts()
    assert boat.severities["trial_identified"] is Severity.WARNING


def test_a_second_trial_is_identified_after_the_first(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a mission with two, on a small computer: the second one was left out without a word."""
    trials = trials_of(boat, KnownTrials())
    completed(boat, monkeypatch)
    boat.supervisor.trial_duty.completed(boat.now_s)
    boat.step(1.0)
    first, trials.runs = trials.runs, Future()
    assert trials.done == ["identify"]
    first.set_result(TrialFinding(True, 0.31))
    boat.step()
    assert trials.done == ["identify", "identify"] and boat.supervisor.trial_duty.identifying
    trials.runs.set_result(TrialFinding(True, 0.25))
    boat.step(1.0)
    assert not boat.supervisor.trial_duty.identifying and trials.done == ["identify", "identify"]
    assert "Trial: new model, error 25% of before. Accept it?" in boat.texts()


def test_a_trial_that_gave_up_is_not(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    trials = trials_of(boat, KnownTrials())
    completed(boat, monkeypatch, "carried out of the circle again and again")
    assert not trials.done


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (TrialResultError("nothing is left to fit"), "Trial: not identified: nothing is left to fit"),
        (ValueError("singular"), "Trial: not identified (ValueError)"),
    ],
)
def test_a_log_that_gives_no_model_is_told(
    boat: Boat, monkeypatch: pytest.MonkeyPatch, error: Exception, said: str
) -> None:
    trials = trials_of(boat, KnownTrials())
    completed(boat, monkeypatch)
    trials.runs.set_exception(error)
    boat.step()
    assert said in boat.texts()


@pytest.mark.parametrize("what", ["accept", "undo"])
def test_the_operators_word_is_told_once_it_is_stored(boat: Boat, what: str) -> None:
    trials = trials_of(boat, KnownTrials(at_once=False))
    outcome, ticket = getattr(boat.supervisor.trial_duty, what)(boat.now_s)
    assert outcome.accepted and ticket is trials.ticket and trials.done == [what]
    boat.step()
    assert "trial_decided" not in boat.names()
    trials.ticket.state = Stored.DURABLE
    boat.step()
    assert any(text.endswith("reboot to use the new model") == (what == "accept") for text in boat.texts())
    assert "trial_decided" in boat.names()


def test_an_accept_that_is_repeated_is_accepted_again_until_it_is_undone(boat: Boat) -> None:
    """Its acknowledgement was lost: the second press of the button was refused, as if nothing had been accepted."""
    trials = trials_of(boat, KnownTrials(at_once=False))
    duty = boat.supervisor.trial_duty
    _, ticket = duty.accept(boat.now_s)
    assert duty.accept(boat.now_s)[1] is ticket and trials.done == ["accept"], "while it is stored"
    trials.ticket.state, trials.proposal = Stored.DURABLE, None
    boat.step(30.0)
    outcome, _ = duty.accept(boat.now_s)
    assert outcome.accepted and trials.done == ["accept"] and boat.names().count("trial_decided") == 1
    assert duty.undo(boat.now_s)[0].accepted
    assert not duty.accept(boat.now_s)[0].accepted


def test_what_could_not_be_stored_is_accepted_anew(boat: Boat) -> None:
    trials = trials_of(boat, KnownTrials(at_once=False))
    boat.supervisor.trial_duty.accept(boat.now_s)
    trials.ticket.state = Stored.FAILED
    boat.step()
    assert boat.supervisor.trial_duty.accept(boat.now_s)[0].accepted and trials.done == ["accept", "accept"]


def test_a_model_found_after_that_is_another(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    trials = trials_of(boat, KnownTrials())
    boat.supervisor.trial_duty.accept(boat.now_s)
    completed(boat, monkeypatch)
    trials.runs.set_result(TrialFinding(True, 0.31))
    boat.step()
    assert boat.supervisor.trial_duty.accept(boat.now_s)[0].accepted
    assert trials.done == ["accept", "identify", "accept"]


def test_what_an_operator_has_set_otherwise_is_told_to_stay(boat: Boat) -> None:
    """It outlasts the accepted model, which nobody was told."""
    trials = trials_of(boat, KnownTrials())
    before = boat.parameters["DP_BW_SWAY"]
    trials.parameters = {"DP_BW_SURGE": 0.453, "DP_BW_SWAY": before + 0.1, "DP_BW_YAW": 0.7}
    assert boat.parameters.set_all({"DP_BW_SURGE": 0.312, "DP_BW_YAW": 0.7}) is None
    boat.supervisor.trial_duty.accept(boat.now_s)
    boat.step()
    told = [text for text in boat.texts() if " stays " in text]
    assert told == ["DP_BW_SURGE stays 0.312 as set; trial: 0.453"] and boat.severities["trial_parameter"] is (
        Severity.WARNING
    )


def test_what_could_not_be_stored_is_an_alarm(boat: Boat) -> None:
    trials = trials_of(boat, KnownTrials(at_once=False))
    boat.supervisor.trial_duty.accept(boat.now_s)
    trials.ticket.reason, trials.ticket.state = "No space left on device", Stored.FAILED
    boat.step()
    assert "Trial: nothing changed: No space left on device" in boat.texts()


def circling(boat: Boat) -> None:
    armed(boat)
    assert boat.supervisor.request_mode(ModeId.CIRCLE, boat.now_s).accepted


@pytest.mark.parametrize(
    ("trials", "bring_about", "reason"),
    [
        (None, None, "no trial result waits"),
        (KnownTrials(proposal=None), None, "no trial result waits"),
        (KnownTrials(), circling, "disarm or choose Hold"),
    ],
)
def test_a_refused_accept_says_why(boat: Boat, trials: KnownTrials | None, bring_about: Any, reason: str) -> None:
    boat.supervisor.trial_duty.results = trials
    if bring_about is not None:
        bring_about(boat)
    outcome, ticket = boat.supervisor.trial_duty.accept(boat.now_s)
    assert (outcome.accepted, outcome.reason, ticket) == (False, f"Trial accept refused: {reason}", None)


def test_nothing_to_undo(boat: Boat) -> None:
    trials_of(boat, KnownTrials(in_force=None))
    outcome, _ = boat.supervisor.trial_duty.undo(boat.now_s)
    assert outcome.reason == "Trial undo refused: the file counts already"


def test_nothing_is_accepted_while_a_trial_is_identified(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    trials_of(boat, KnownTrials())
    completed(boat, monkeypatch)
    outcome, _ = boat.supervisor.trial_duty.accept(boat.now_s)
    assert outcome.reason == "Trial accept refused: still identifying"
