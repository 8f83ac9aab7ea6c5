"""What a leader module says and what of it arrives: content, clock, rates, loss, cuts, and the lead boat of each
kind."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.config.vessel import ConfigError, HomeConfig
from companion.core.geodesy import LocalFrame
from sitl.lead_boat import LeadBoat
from sitl.leader_radio import KINDS, WISH_AUTONOMOUS, WISH_REMOTE, EmulatedLeaderModule, RadioPath
from sitl.leader_script import script

HOME = HomeConfig(57.63, 11.55, 0.0)
FRAME = LocalFrame(HOME.lat_deg, HOME.lon_deg)


def boat(gnss: str = "basin", seed: int = 1) -> LeadBoat:
    lead = LeadBoat("leader", HOME, script("uturn@8.2"), gnss=gnss, seed=seed)
    lead.depart(0.0)
    return lead


def said(lead: LeadBoat, module: EmulatedLeaderModule, until_s: float) -> list[tuple[float, bytes, Any]]:
    """(time sent, packet, parsed message) up to a time."""
    parser = mavlink.MAVLink(None)
    heard = []
    while module.due_s <= until_s:
        now_s = module.due_s
        while lead.t_s < now_s - 0.02:
            lead.step()
        for packet in module.speak():
            (message,) = parser.parse_buffer(packet)
            heard.append((now_s, packet, message))
    return heard


def of(heard: list[tuple[float, bytes, Any]], kind: str) -> list[tuple[float, Any]]:
    return [(t_s, message) for t_s, _, message in heard if message.get_type() == kind]


def test_positions_are_where_the_boat_is_when_they_are_sent() -> None:
    lead = boat()
    module = EmulatedLeaderModule(lead, gnss="basin", seed=3)
    parser = mavlink.MAVLink(None)
    worst = 0.0
    while lead.t_s < 75.0:  # past the sharp turn at 60 s
        while lead.t_s < module.due_s:
            lead.step()
        early_s = lead.t_s - module.due_s
        for packet in module.speak():
            (message,) = parser.parse_buffer(packet)
            if message.get_type() == "FOLLOW_TARGET":
                north_m, east_m = FRAME.to_ned(message.lat * 1e-7, message.lon * 1e-7)
                hull = lead.hull
                away = math.hypot(
                    hull.north_m - hull.north_mps * early_s - north_m, hull.east_m - hull.east_mps * early_s - east_m
                )
                worst = max(worst, away)
                yaw = 2.0 * math.atan2(message.attitude_q[3], message.attitude_q[0])
                assert abs(math.remainder(yaw - hull.yaw_rad, math.tau)) < math.radians(9.0), (
                    "four sigma of its compass, and what it turns in a step"
                )
                assert message.custom_state == 0x55535600 | WISH_AUTONOMOUS | 6 << 40 and message.est_capabilities == 11
                assert message.position_cov[0] == pytest.approx(math.hypot(0.001, 0.001))
    assert worst < 0.10, (
        "of a receiver that is exact to millimetres; dead reckoning over a tenth of a second in a turn is not"
    )


def test_rate_and_clock() -> None:
    lead = boat()
    module = EmulatedLeaderModule(lead, seed=5)
    heard = said(lead, module, 20.0)
    positions = of(heard, "FOLLOW_TARGET")
    assert len(of(heard, "HEARTBEAT")) == 20
    assert all(b - a == pytest.approx(0.05) for (a, _), (b, _) in pairwise(positions))
    offset_ms = [message.timestamp - 1000.0 * t_s for t_s, message in positions]
    assert max(offset_ms) - min(offset_ms) < 2.1, "a drift of at most 50 ppm, and whole milliseconds"
    assert offset_ms[0] > 4000.0, "no clock of ours"


def test_budget_of_the_radio() -> None:
    """One whole message a second and 19 short ones between: under 1,875 bytes a second with the heartbeat."""
    lead = boat()
    module = EmulatedLeaderModule(lead, kind="radio", seed=5)
    heard = [(t_s, packet, message) for t_s, packet, message in said(lead, module, 41.0) if 1.0 <= t_s < 41.0]
    assert sum(len(packet) for _, packet, _ in heard) / 40.0 < 1875.0
    capable = [message.est_capabilities for _, message in of(heard, "FOLLOW_TARGET")]
    assert capable.count(11) == 40 and capable.count(0) == 760


def test_a_lost_fix_is_said_at_once() -> None:
    lead = boat()
    module = EmulatedLeaderModule(lead, kind="radio", seed=2)
    said(lead, module, 5.0)
    lead.faults.add("gnss_lost")
    messages = of(said(lead, module, 6.0), "FOLLOW_TARGET")
    without = [message for t_s, message in messages if t_s > 5.15]
    assert all((message.lat, message.lon) == (0, 0) and list(message.vel) == [0.0] * 3 for message in without)
    assert next(message.est_capabilities for _, message in messages if message.est_capabilities) == 8
    lead.faults.clear()
    assert next(m.est_capabilities for t_s, m in of(said(lead, module, 6.5), "FOLLOW_TARGET") if m.lat) == 11


def test_phone_mavsdk_and_vehicle() -> None:
    lead = boat()
    phone = of(said(lead, EmulatedLeaderModule(lead, kind="phone", seed=1), 10.0), "FOLLOW_TARGET")
    assert len(phone) in (40, 41) and phone[-1][1].est_capabilities == 3 and list(phone[-1][1].attitude_q) == [0.0] * 4
    kit = of(said(lead, EmulatedLeaderModule(lead, kind="mavsdk", seed=1), 20.0), "FOLLOW_TARGET")
    assert (
        len(kit) in (10, 11)
        and kit[-1][1].timestamp == 0
        and math.isnan(kit[-1][1].attitude_q[1])
        and kit[-1][1].est_capabilities == 1
    )
    module = EmulatedLeaderModule(lead, kind="vehicle", seed=1)
    told = of(said(lead, module, 30.0), "GLOBAL_POSITION_INT")
    assert told[-1][1].get_srcSystem() == module.system and math.hypot(told[-1][1].vx, told[-1][1].vy) == pytest.approx(
        820.0, abs=40.0
    )
    assert FRAME.to_ned(told[-1][1].lat * 1e-7, told[-1][1].lon * 1e-7) == pytest.approx(
        (lead.hull.north_m, lead.hull.east_m), abs=0.6
    )


def test_wish_and_sticks() -> None:
    lead = boat()
    module = EmulatedLeaderModule(lead, seed=1)
    module.wish, module.sticks = WISH_REMOTE, (0, 300, 500, 0)
    heard = said(lead, module, 2.0)
    assert of(heard, "FOLLOW_TARGET")[-1][1].custom_state & 0xFF == WISH_REMOTE
    sticks = of(heard, "MANUAL_CONTROL")
    assert len(sticks) >= 35 and (sticks[0][1].x, sticks[0][1].y, sticks[0][1].z, sticks[0][1].r) == (0, 300, 500, 0)


def test_the_time_is_told_to_who_asks() -> None:
    lead = boat()
    module = EmulatedLeaderModule(lead, seed=5)
    question = mavlink.MAVLink_timesync_message(0, 77)
    answer = module.answer(question, 10.0)
    assert answer is not None
    (told,) = mavlink.MAVLink(None).parse_buffer(answer)
    assert told.tc1 == pytest.approx(1e6 * module.clock_ms(10.0), abs=1e6) and told.ts1 == 77
    assert EmulatedLeaderModule(lead, kind="phone").answer(question, 10.0) is None
    assert module.answer(told, 10.0) is None, "an answer is no question"


def test_loss_latency_and_cuts() -> None:
    path = RadioPath("a", latency_s=0.08, jitter_s=0.02, loss=0.5, cuts=((10.0, 0.4),), seed=4)
    for k in range(2000):
        path.take(0.05 * k, bytes([k % 256]))
    arrived = path.arrived(math.inf)
    assert 900 < len(arrived) < 1100
    delays = [at_s - 0.05 * round((at_s - 0.08) / 0.05) for at_s, _ in arrived]
    assert sum(delays) / len(delays) == pytest.approx(0.08, abs=0.005) and min(delays) >= 0.04 - 1e-9
    assert not [at_s for at_s, _ in arrived if 10.16 < at_s < 10.42], "nothing of what was sent in the cut"
    assert all(a <= b for (a, _), (b, _) in pairwise(arrived))
    again = RadioPath("a", latency_s=0.08, jitter_s=0.02, loss=0.5, cuts=((10.0, 0.4),), seed=4)
    other = RadioPath("b", latency_s=0.08, jitter_s=0.02, loss=0.5, cuts=((10.0, 0.4),), seed=4)
    for k in range(2000):
        again.take(0.05 * k, bytes([k % 256]))
        other.take(0.05 * k, bytes([k % 256]))
    assert again.arrived(math.inf) == arrived != other.arrived(math.inf)


def test_what_does_not_exist_is_said() -> None:
    with pytest.raises(ConfigError, match="module, radio, phone"):
        EmulatedLeaderModule(boat(), kind="gull")
    with pytest.raises(ConfigError, match="0 to 1"):
        RadioPath("a", loss=1.5)
    assert set(KINDS) == {"module", "radio", "phone", "mavsdk", "vehicle"}
