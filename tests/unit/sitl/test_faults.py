"""Faults as a person writes them."""

from __future__ import annotations

import math

import pytest

from companion.config.vessel import ConfigError, find, load
from sitl.faults import Fault, Faults, known, parse

VESSEL = load(find("revolt"))


def test_parse() -> None:
    assert parse("gnss_lost@120+12", VESSEL) == Fault("gnss_lost", 120.0, 132.0)
    assert parse("leak@1.5", VESSEL) == Fault("leak", 1.5, math.inf)
    assert parse("thruster_bow_dead@0", VESSEL) == Fault("thruster_bow_dead", 0.0, math.inf)


@pytest.mark.parametrize(
    "name", ["gnss_lost", "heading_lost", "imu_lost", "leak", "battery_low", "mcu_silent", "rc_safe", "gnss_jump"]
)
def test_the_promised_faults_are_there(name: str) -> None:
    assert name in known(VESSEL)


def test_a_thruster_has_the_faults_that_it_can_have() -> None:
    names = known(VESSEL)
    assert {
        "thruster_bow_dead",
        "thruster_bow_stalled",
        "thruster_bow_runaway",
        "thruster_bow_jammed",
        "thruster_stern_port_stuck",
    } <= set(names)
    assert "thruster_bow_stuck" not in names and "thruster_stern_port_jammed" not in names


@pytest.mark.parametrize(
    "text",
    [
        "gnss_lost",
        "gnss_lost@",
        "gnss_lost@x",
        "gnss_lost@1+",
        "gnss_lost@1+0",
        "leak@-1",
        "leak@nan",
        "@5",
        "leak@1+nan",
    ],
)
def test_a_fault_badly_written_says_how(text: str) -> None:
    with pytest.raises(ConfigError, match=r"NAME@T|no fault named"):
        parse(text, VESSEL)


@pytest.mark.parametrize(
    ("text", "limits"),
    [("gnss_dropped=30@3", "0 to 1"), ("gnss_late=-1@3", "0 to 10 s"), ("gnss_late=60@3", "0 to 10 s")],
)
def test_a_size_that_means_nothing_is_refused(text: str, limits: str) -> None:
    with pytest.raises(ConfigError, match=f"fault '{text}': the size must be {limits}$"):
        parse(text, VESSEL)


def test_an_unknown_fault_names_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r"no fault named 'kraken'; known: .*gnss_lost.*thruster_stern_port_dead"):
        parse("kraken@10", VESSEL)


def test_every_wrong_fault_is_named_at_once() -> None:
    with pytest.raises(ConfigError) as caught:
        Faults(["kraken@10", "leak", "leak@5"], VESSEL)
    assert len(caught.value.problems) == 2


def test_active_over_time() -> None:
    faults = Faults(["leak@1+2", "gnss_lost@2"], VESSEL)
    seen = []
    for k in range(500):
        faults.update(k / 100)
        seen.append(faults.active)
    assert seen[99] == frozenset()
    assert seen[100] == {"leak"} == seen[199]
    assert seen[200] == {"leak", "gnss_lost"} == seen[299]
    assert seen[300] == {"gnss_lost"} == seen[499]


def test_a_fault_can_be_added_under_way() -> None:
    faults = Faults([], VESSEL)
    assert faults.update(1.0)
    assert not faults.update(2.0)
    faults.add(Fault("leak", 2.0))
    assert faults.update(2.01)
    assert faults.active == {"leak"}
    assert faults.planned("le") and not faults.planned("rc_")
