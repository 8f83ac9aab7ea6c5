"""Every text that the boat can send: its kind, and by that its severity."""

from __future__ import annotations

import re

import pytest

from companion.core.decision import Severity, TextKind
from docs.generate.reasons import plan_reasons, reasons
from docs.generate.source import ROOT, modules
from docs.generate.statustexts import Said, all_texts, severity
from docs.generate.text_lengths import CHUNK, EXAMPLES, PLACES, WHY_LONG, usual_length

_REFUSES = re.compile(r"refused|not obeyed|broke off|^param|should be|not changed|not erased|^no such")
_ROUTINE = (
    "Mode {mode}",
    "Armed",
    "Disarmed",
    "Mission complete",
    "Home set here",
    "Position is back",
    "Sticks are back",
)


def test_the_severities_of_the_kinds() -> None:
    assert {kind.name: kind.severity.name for kind in TextKind} == {
        "ROUTINE": "INFO",
        "HINT": "INFO",
        "ATTENTION": "WARNING",
        "REFUSAL": "ERROR",
        "FAULT": "ERROR",
        "ALARM": "CRITICAL",
        "DANGER": "ALERT",
    }


def test_only_the_table_of_kinds_names_severities() -> None:
    """So that no text has a severity of its own."""
    naming = {
        module.place
        for module in modules("companion")
        if re.search(r"Severity\.[A-Z]", (ROOT / module.place).read_text(encoding="utf-8"))
    }
    assert naming == {"companion/core/decision.py"}


@pytest.fixture(scope="module")
def texts() -> list[Said]:
    return sorted(set(all_texts()))


def test_a_refusal_of_the_supervisor_is_an_error(texts: list[Said]) -> None:
    refusals = [one for one in texts if one.name == "refused"]
    assert refusals and not [one for one in refusals if severity(one) != Severity.ERROR.name]


def test_a_refusal_of_a_command_is_an_error(texts: list[Said]) -> None:
    refusals = [one for one in texts if not one.name and _REFUSES.search(one.text) and one.kind != "HINT"]
    assert refusals and not [one for one in refusals if severity(one) != Severity.ERROR.name]


def test_a_hint_answers_only_what_programs_ask(texts: list[Said]) -> None:
    hints = {one.place for one in texts if one.kind == TextKind.HINT.name}
    assert hints == {"companion/io/mavlink/commands/messages.py"}


@pytest.mark.parametrize("text", _ROUTINE)
def test_a_routine_notice_is_quiet(text: str, texts: list[Said]) -> None:
    (said,) = {(one.text, severity(one)) for one in texts if one.text == text}
    assert said == (text, Severity.INFO.name)


def test_a_text_fits_one_message_unless_it_is_listed_with_the_reason_why_not(texts: list[Said]) -> None:
    long = {one.text for one in texts if one.length > CHUNK and any(map(str.isalpha, PLACES.sub("", one.text)))}
    assert long == set(WHY_LONG)


def test_the_usual_values_are_of_places_that_texts_have(texts: list[Said]) -> None:
    reason_texts = [one.text for one in (*reasons(), *plan_reasons())]
    named = {place[1:-1] for text in (*(one.text for one in texts), *reason_texts) for place in PLACES.findall(text)}
    assert set(EXAMPLES) <= named, "no longer used"


def test_reasons_are_found_where_functions_and_rules_give_them() -> None:
    found = {one.text for one in reasons()}
    assert {"outside the fence", "no mission loaded", "system {in_control} has control"} <= found
    assert "DO_JUMP to itself; jump to another item" in {one.text for one in plan_reasons()}


def test_a_reason_fits_one_message() -> None:
    assert not [one for one in reasons() if usual_length(one.text) > CHUNK]


def test_nothing_is_a_notice(texts: list[Said]) -> None:
    """QGroundControl prints it in red and speaks it."""
    assert not [one for one in texts if "NOTICE" in severity(one)]
