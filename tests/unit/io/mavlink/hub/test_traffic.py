"""AIS_VESSEL: every vessel in its turn, none more than once a second, at the interval asked for; and in from other
systems."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import pytest

from companion.core.estimate import TrackedTarget
from companion.core.readings import AisTarget
from companion.io.mavlink.telemetry.traffic import Rounds, adsb_vehicle, ais_vessel, from_ais_vessel
from companion.io.mavlink.wire import messages as mavlink
from companion.traffic.tracker import TrafficTracker
from tests.unit.io.mavlink.hub.conftest import Rig

AIS = mavlink.MAVLINK_MSG_ID_AIS_VESSEL


class Outlet:
    pass


def vessels(count: int) -> tuple[TrackedTarget, ...]:
    return tuple(TrackedTarget(AisTarget(0.0, "ais", 100 + n, 60.0, 22.0), 0.0, 1) for n in range(count))


@pytest.mark.parametrize("count", [1, 3, 5, 12, 200])
def test_each_in_its_turn_and_none_more_than_once_a_second(count: int) -> None:
    rounds, outlet, sent = Rounds(), Outlet(), []
    for n in range(600):
        vessel = rounds.next(outlet, vessels(count), n * 0.2)  # type: ignore[arg-type]
        if vessel is not None:
            sent.append((n * 0.2, vessel.known.mmsi))
    times: dict[int, float] = {}
    for t_s, mmsi in sent:
        assert t_s - times.get(mmsi, -math.inf) >= 1.0 - 1e-6
        times[mmsi] = t_s
    counts = Counter(mmsi for _, mmsi in sent)
    assert len(counts) == count and max(counts.values()) - min(counts.values()) <= 1
    assert len(sent) == (600 if count >= 5 else pytest.approx(120 * count, rel=0.02))


def test_a_vessel_that_is_gone_does_not_stop_the_round() -> None:
    rounds, outlet = Rounds(), Outlet()
    all_of = vessels(6)
    assert [rounds.next(outlet, all_of, 0.0).known.mmsi for _ in range(3)] == [100, 101, 102]  # type: ignore[arg-type, union-attr]
    assert rounds.next(outlet, all_of[4:], 0.1).known.mmsi == 104  # type: ignore[arg-type, union-attr]
    assert rounds.next(outlet, (), 0.2) is None  # type: ignore[arg-type]


def test_what_is_told_comes_back() -> None:
    known = AisTarget(
        5.0,
        "mavlink:9",
        230_123_456,
        60.1234567,
        -22.7654321,
        1.0,
        3.21,
        6.0,
        -0.05,
        3,
        37,
        12.0,
        4.0,
        2.0,
        1.0,
        "OH1234",
        "NORA",
    )
    back = from_ais_vessel(received(ais_vessel(TrackedTarget(known, 7.0, 2), 8.0)), 9, 8.0)
    for name in (
        "t_s",
        "mmsi",
        "lat_deg",
        "lon_deg",
        "status",
        "kind",
        "bow_m",
        "stern_m",
        "port_m",
        "starboard_m",
        "callsign",
        "name",
        "source",
    ):
        assert (
            getattr(back, name) == pytest.approx(getattr(known, name))
            if isinstance(getattr(known, name), float)
            else getattr(back, name) == getattr(known, name)
        )
    assert back.course_rad == pytest.approx(1.0, abs=1e-4) and back.heading_rad == pytest.approx(6.0, abs=1e-4)
    assert back.speed_mps == pytest.approx(3.21) and back.turn_rate_radps == pytest.approx(-0.05, abs=1e-3)


def test_what_is_not_known_stays_unknown() -> None:
    known = AisTarget(0.0, "mavlink:9", 1, 60.0, 22.0)
    back = from_ais_vessel(received(ais_vessel(TrackedTarget(known, 0.0, 1), 0.0)), 9, 0.0)
    assert back == known


def test_boats_that_pass_a_vessel_on_to_each_other_forget_it() -> None:
    """Three boats hear each other's AIS_VESSEL, a third of a second apart; the vessel itself is silent from 0 s on."""
    boats = [TrafficTracker() for _ in range(3)]
    boats[0].take(AisTarget(0.0, "ais", 7, 63.441, 10.401, course_rad=0.0, speed_mps=5.0), 0.0, None)
    for step in range(3 * 120):
        now_s, teller = step / 3.0, step % 3
        for boat in boats:
            boat.update(now_s)
        for vessel in boats[teller].targets:
            for listener in {0, 1, 2} - {teller}:
                boats[listener].take(from_ais_vessel(ais_vessel(vessel, now_s), teller, now_s), now_s, None)
    assert [boat.targets for boat in boats] == [(), (), ()]


def heard(rig: Rig) -> list[int]:
    return [message.MMSI for message in rig.desk.hear() if message.get_type() == "AIS_VESSEL"]


def test_streamed_at_the_interval_asked_for(rig: Rig) -> None:
    rig.run(5.0)
    assert heard(rig) == [], "an empty sea costs nothing"
    rig.supervisor.change(traffic=vessels(10))
    rig.run(10.0)
    assert sorted(heard(rig)) == sorted([*range(100, 110)] * 5)
    rig.ask(mavlink.MAVLink_command_long_message(1, 1, 511, 0, AIS, 100_000.0, 0, 0, 0, 0, 0))
    heard(rig)
    rig.run(10.0)
    assert len(heard(rig)) == pytest.approx(100, abs=1)
    rig.ask(mavlink.MAVLink_command_long_message(1, 1, 511, 0, AIS, -1.0, 0, 0, 0, 0, 0))
    rig.run(3.0)
    assert heard(rig) == []


def test_one_message_asked_for_is_the_nearest_vessel(rig: Rig) -> None:
    near = AisTarget(0.0, "ais", 500, 63.441, 10.401)
    rig.supervisor.change(traffic=(*vessels(2), TrackedTarget(near, 0.0, 1)))
    rig.run(0.1)
    answers = rig.ask(mavlink.MAVLink_command_long_message(1, 1, 512, 0, AIS, 0, 0, 0, 0, 0, 0))
    assert [message.MMSI for message in answers if message.get_type() == "AIS_VESSEL"] == [500]


def test_what_another_system_sees_reaches_the_supervisor(rig: Rig) -> None:
    rig.run(1.0)
    rig.ask(ais_vessel(TrackedTarget(AisTarget(0.0, "x", 500, 63.441, 10.401, name="NORA"), 0.0, 1), 0.0))
    assert rig.supervisor.reports == [
        AisTarget(1.0, "mavlink:255", 500, pytest.approx(63.441), pytest.approx(10.401), name="NORA")
    ]


def test_a_boat_that_leads_is_no_vessel_to_itself(rig: Rig) -> None:
    """Its follower shows it, with its system id as MMSI."""
    rig.run(1.0)
    for system in (1, 2):
        rig.ask(ais_vessel(TrackedTarget(AisTarget(0.0, "leader", system, 63.441, 10.401), 0.0, 1), 0.0))
    assert [report.mmsi for report in rig.supervisor.reports] == [2]


def received(message: Any) -> Any:
    """Packed and parsed by pymavlink itself."""
    from pymavlink.dialects.v20 import common

    data = message.pack(common.MAVLink(None, srcSystem=9, srcComponent=156))
    (back,) = common.MAVLink(None).parse_buffer(data)
    return back


def test_ground_stations_that_know_aircraft_only_see_the_vessels_too(rig: Rig) -> None:
    rig.supervisor.change(traffic=vessels(3))
    rig.run(5.0)
    shown = [message for message in rig.desk.hear() if message.get_type() == "ADSB_VEHICLE"]
    assert {message.ICAO_address for message in shown} == {100, 101, 102} and 12 <= len(shown) <= 18
    known = AisTarget(0.0, "ais", 257_000_001, 63.441, 10.401, course_rad=math.pi / 2, speed_mps=5.0, name="NORA")
    back = received(adsb_vehicle(TrackedTarget(known, 0.0, 1), 3.0))
    assert (back.ICAO_address, back.heading, back.hor_velocity, back.callsign, back.tslc) == (
        257_000_001,
        9000,
        500,
        "NORA",
        3,
    )
    assert (back.lat, back.lon) == (634410000, 104010000) and back.emitter_type == 18
