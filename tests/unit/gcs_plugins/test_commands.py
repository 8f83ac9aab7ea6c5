"""The table of actions by itself: numbers, labels, the parameters that tuning steps."""

from __future__ import annotations

import math

from companion.io.mavlink.wire import messages as mavlink
from companion.params.table import TABLE
from gcs_plugins.commands import ACTIONS, BY_NAME, LONGEST_LABEL, TUNING, MavCmd

# what QGroundControl's joystick page offers by itself; a custom action of the same name would hide behind it
BUILT_IN = {
    "Arm",
    "Disarm",
    "Toggle Arm",
    "No Action",
    "Center",
    "Manual",
    "Forces",
    "Heading",
    "Hold",
    "Mission",
    "RTL",
    "Dock",
    "Follow",
    "Offboard",
}


def test_numbers_are_those_of_mavlink() -> None:
    assert {command.name: int(command) for command in MavCmd} == {
        c.name: getattr(mavlink, f"MAV_CMD_{c.name}") for c in MavCmd
    }


def test_names_and_labels() -> None:
    assert len(BY_NAME) == len(ACTIONS)
    labels = [action.label for action in ACTIONS]
    assert len(set(labels)) == len(labels) and not BUILT_IN & set(labels)
    for action in ACTIONS:
        assert 0 < len(action.label) <= LONGEST_LABEL and action.label.isascii() and action.text.isascii()
        assert all(math.isfinite(value) for value in action.params), "JSON has no NaN"
        assert (action.mode is None) == (action.command is not MavCmd.DO_SET_MODE)


def test_what_starts_thrust_or_motion_or_ends_it_under_way_is_asked_for_first() -> None:
    """A slip on any other button leaves the boat where it is, or the next click takes it back."""
    asked = {action.name for action in ACTIONS if not action.at_once}
    assert asked == {
        "arm", "disarm",  # propellers turn; a boat under way drifts
        "start", "continue", "restart", "return", "dock", "circle", "follow", "trial",  # the boat sails off
        "set-home",  # what a failsafe does later
        "lower", "retract",  # moves what could hurt somebody
    }  # fmt: skip
    assert all(action.asks.isascii() and len(action.asks) <= 60 for action in ACTIONS)


def test_an_emergency_stop_does_not_ask() -> None:
    assert BY_NAME["stop"].at_once and BY_NAME["stop"].joystick and BY_NAME["hold"].at_once


def test_no_stick_has_a_button_for_what_is_asked_for_first() -> None:
    assert all(action.at_once for action in ACTIONS if action.joystick or action.button is not None)


def test_each_button_means_one_thing() -> None:
    taken = [(action.button, action.shift) for action in ACTIONS if action.button is not None]
    assert len(set(taken)) == len(taken)
    assert all(action.joystick for action in ACTIONS if action.button is not None)


def test_tuning_steps_bandwidths_that_exist() -> None:
    specs = {spec.name: spec for spec in TABLE}
    assert all(specs[name].unit == "rad/s" for names in TUNING.values() for name in names)
