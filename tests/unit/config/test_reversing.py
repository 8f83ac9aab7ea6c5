"""What a boat can do astern and without way."""

from __future__ import annotations

from dataclasses import replace

from companion.config.reversing import stern_first_refusal, turns_in_place, turns_on_the_spot
from companion.config.vessel import find, load
from tests.unit.rudder_boat import SKIFF

REVOLT, OTTER, JET = (load(find(name)) for name in ("revolt", "otter", "rescuerunner"))


def test_who_sails_stern_first() -> None:
    assert stern_first_refusal(REVOLT.thrusters) is None and stern_first_refusal(OTTER.thrusters) is None
    assert stern_first_refusal(JET.thrusters) == "this boat has no way astern"
    assert stern_first_refusal(SKIFF.thrusters) == "this boat does not steer astern"
    ahead_only = tuple(replace(thruster, min_n=0.0) for thruster in OTTER.thrusters)
    assert stern_first_refusal(ahead_only) == "this boat has no way astern"
    assert stern_first_refusal(()) == "this boat has no way astern"


def test_who_turns_on_the_spot() -> None:
    assert turns_on_the_spot(REVOLT.thrusters) and turns_on_the_spot(OTTER.thrusters)
    assert not turns_on_the_spot(JET.thrusters) and not turns_on_the_spot(SKIFF.thrusters)


def test_a_lone_outboard_goes_on_as_it_turns() -> None:
    outboard = replace(JET.thrusters[0], kind="azimuth", min_n=-300.0)
    assert turns_on_the_spot((outboard,)) and not turns_in_place((outboard,))
    assert turns_in_place((replace(outboard, azimuth_min_rad=None, azimuth_max_rad=None),)), "a pod pushes sideways"
    assert turns_in_place(OTTER.thrusters) and turns_in_place(REVOLT.thrusters)
    assert not turns_in_place(JET.thrusters) and not turns_in_place(SKIFF.thrusters)
