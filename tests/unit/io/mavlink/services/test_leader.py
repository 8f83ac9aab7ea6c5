"""What is made of the messages that tell of a lead boat, from their bytes."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from typing import Any

import pytest

from companion.core.readings import FixType, LeaderState, Wish
from companion.io.mavlink.services.leader import LeaderService
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import frame, pack
from companion.io.mavlink.wire.hub import Peer
from companion.io.mavlink.wire.link_base import take_in
from companion.leader_module.messages import follow_target
from companion.supervisor.authority import AuthorityRequest, Facts, refusal
from tests.unit.estimates import AT_REST

NAN = math.nan
NAV = replace(
    AT_REST,
    t_s=12.5,
    lat_deg=57.63,
    lon_deg=11.55,
    altitude_m=0.4,
    north_m=3.0,
    east_m=-4.0,
    roll_rad=0.1,
    pitch_rad=-0.05,
    yaw_rad=2.1,
    surge_mps=8.0,
    sway_mps=0.1,
    north_mps=-4.1,
    east_mps=6.9,
    roll_rate_radps=0.01,
    pitch_rate_radps=0.02,
    yaw_rate_radps=0.13,
    position_accuracy_m=1.4,
    velocity_accuracy_mps=0.1,
    heading_accuracy_rad=0.02,
    position_age_s=0.05,
    heading_age_s=0.05,
    imu_age_s=0.01,
    fix=FixType.FIX_3D,
    satellites=12,
    hdop=0.9,
)


class Follower:
    """The service with a supervisor that writes down what it hears."""

    def __init__(self, desk: Any) -> None:
        self.desk, self.states = desk, []
        desk.supervisor.leader_heard = self.states.append
        desk.supervisor.refusal = self.refusal
        self.service = desk.serve(LeaderService(desk.hub, desk.vessel))
        self._sequences: dict[tuple[int, int], int] = {}

    def refusal(self, request: AuthorityRequest, now_s: float) -> str | None:
        return refusal(request, Facts(chosen_leader=int(self.desk.vessel.parameters["FOLL_SYSID"])))

    def peer(self, system: int = 42, component: int = 191) -> Peer:
        return Peer(self.desk.peer("qgc").endpoint, system, component)

    def tell(self, message: Any, system: int = 42, component: int = 191, skip: int = 0) -> LeaderState | None:
        """Through framing and the endpoint's counts; `skip`: so many were lost before it. Returns what was made of
        it."""
        endpoint, before = self.desk.peer("qgc").endpoint, len(self.states)
        sequence = self._sequences.get((system, component), -1) + 1 + skip
        self._sequences[system, component] = sequence
        received: list[tuple[Any, Any]] = []
        take_in(
            endpoint,
            endpoint.framer.feed(frame(pack(message), sequence & 0xFF, system, component)),
            self.desk.now_s,
            received,
        )
        for _, one in received:
            self.service.handles[one.id](one, self.peer(system, component), self.desk.now_s)
        return self.states[-1] if len(self.states) > before else None


@pytest.fixture
def follower(desk: Any) -> Follower:
    return Follower(desk)


def target(**fields: Any) -> Any:
    known = {
        "timestamp": 1000,
        "est_capabilities": 3,
        "lat": 576300000,
        "lon": 115500000,
        "alt": 0.0,
        "vel": (3.0, 4.0, 0.0),
        "acc": (0.0,) * 3,
        "attitude_q": (0.0,) * 4,
        "rates": (0.0,) * 3,
        "position_cov": (2.5, 0.0, 0.0),
        "custom_state": 0,
    }
    return mavlink.MAVLink_follow_target_message(**{**known, **fields})


def test_a_module_says_which_kind_of_fix_it_has(follower: Follower) -> None:
    """Receivers of one kind can be compared. Modules of before and other senders do not say it."""
    for fix in (FixType.FIX_3D, FixType.DGPS, FixType.RTK_FIXED):
        state = follower.tell(follow_target(replace(NAV, fix=fix), True, Wish.REMOTE, 200, True))
        assert state is not None and (state.fix, state.presses, state.wish) == (fix, 200, Wish.REMOTE)
    lost = follower.tell(follow_target(NAV, False, Wish.REMOTE, 200, True))
    before = follower.tell(target(custom_state=0x55535600 | 7 << 32 | 3))
    phone = follower.tell(target(custom_state=5 << 40), system=250, component=190)
    assert lost is not None and before is not None and phone is not None
    assert (lost.fix, before.fix, phone.fix) == (None, None, None)


def test_a_module_says_all_that_it_knows(follower: Follower) -> None:
    state = follower.tell(follow_target(NAV, True, Wish.AUTONOMOUS, 7, True))
    assert state is not None and (state.system_id, state.source, state.wish, state.presses) == (
        42,
        "mavlink:42",
        Wish.AUTONOMOUS,
        7,
    )
    assert state.lat_deg == pytest.approx(57.63, abs=1e-7) and state.lon_deg == pytest.approx(11.55, abs=1e-7)
    assert (state.north_mps, state.east_mps) == pytest.approx((-4.1, 6.9), abs=1e-5)
    assert state.yaw_rad == pytest.approx(2.1, abs=1e-6) and state.yaw_rate_radps == pytest.approx(0.13)
    assert state.accuracy_m == pytest.approx(1.4)


def test_short_messages_are_as_the_last_whole_one(follower: Follower) -> None:
    follower.tell(follow_target(NAV, True, Wish.REMOTE, 1, True))
    short = follow_target(NAV, True, Wish.REMOTE, 1, False)
    assert (
        len(pack(short).payload) + 12 == 92
        and len(pack(follow_target(NAV, True, Wish.REMOTE, 1, True)).payload) + 12 == 105
    )
    state = follower.tell(short)
    assert (
        state is not None and state.accuracy_m == pytest.approx(1.4) and state.yaw_rad == pytest.approx(2.1, abs=1e-6)
    )
    assert state.north_mps is not None and state.wish is Wish.REMOTE
    follower.tell(follow_target(replace(NAV, heading_valid=False), True, Wish.REMOTE, 1, True))
    state = follower.tell(follow_target(NAV, True, Wish.REMOTE, 1, False))
    assert state is not None and state.yaw_rad is None, "the last whole one had no attitude"


def test_a_short_message_before_the_first_whole_one_counts_by_what_it_bears(follower: Follower) -> None:
    state = follower.tell(follow_target(NAV, True, Wish.MANUAL, 1, False))
    assert state is not None and state.lat_deg is not None and state.yaw_rad is not None and state.accuracy_m is None


@pytest.mark.parametrize("whole", [True, False])
def test_a_module_without_a_fix_or_heading_says_so_at_once(follower: Follower, whole: bool) -> None:
    follower.tell(follow_target(NAV, True, Wish.AUTONOMOUS, 1, True))
    state = follower.tell(follow_target(NAV, False, Wish.AUTONOMOUS, 1, whole))
    assert state is not None and state.lat_deg is None and state.north_mps is (None if whole else state.north_mps)
    assert state.wish is Wish.AUTONOMOUS and state.yaw_rad is not None
    state = follower.tell(follow_target(replace(NAV, heading_valid=False), True, Wish.AUTONOMOUS, 1, whole))
    assert state is not None and state.lat_deg is not None and state.yaw_rad is None


def test_a_wish_that_nobody_knows_is_none(follower: Follower) -> None:
    state = follower.tell(target(custom_state=0x555356EE))
    assert state is not None and state.wish is Wish.NONE
    state = follower.tell(target(custom_state=0x55535700 | 3))
    assert state is not None and state.wish is None, "not the mark of a module"


def test_qgroundcontrol_has_no_heading(follower: Follower) -> None:
    state = follower.tell(target(), system=255, component=190)
    assert state is not None and state.yaw_rad is None and state.wish is None
    assert (state.north_mps, state.east_mps, state.accuracy_m) == (3.0, 4.0, 2.5)


@pytest.mark.parametrize(
    ("vel", "known"),
    [
        ((3.0, 4.0, NAN), True),
        ((NAN, NAN, NAN), False),
        ((0.0, 0.0, 0.0), False),
        ((0.0, -1.5, 0.0), True),
        ((1e9, 0.0, 0.0), False),
    ],
)
def test_mavsdk_fills_in_a_velocity_without_saying_so(follower: Follower, vel: tuple[float, ...], known: bool) -> None:
    message = target(
        timestamp=0,
        est_capabilities=1,
        vel=vel,
        attitude_q=(1.0, NAN, NAN, NAN),
        rates=(NAN,) * 3,
        position_cov=(NAN,) * 3,
    )
    state = follower.tell(message, system=245)
    assert state is not None and state.lat_deg is not None and state.yaw_rad is None and state.accuracy_m is None
    assert (state.north_mps is not None) == known
    assert state.t_s == pytest.approx(follower.desk.now_s - follower.desk.parameters["FOLL_LATENCY"])


def test_a_standing_leader_that_claims_its_velocity_stands(follower: Follower) -> None:
    state = follower.tell(target(vel=(0.0, 0.0, 0.0)), system=255)
    assert state is not None and (state.north_mps, state.east_mps) == (0.0, 0.0)


def test_an_attitude_without_a_claim_is_none(follower: Follower) -> None:
    """(1, 0, 0, 0) is what senders leave there: it does not say that the bow points north."""
    state = follower.tell(target(attitude_q=(1.0, 0.0, 0.0, 0.0)), system=255)
    assert state is not None and state.yaw_rad is None
    state = follower.tell(target(est_capabilities=11, attitude_q=(1.0, 0.0, 0.0, 0.0)), system=255)
    assert state is not None and state.yaw_rad == 0.0


@pytest.mark.parametrize(
    "fields", [{"lat": 900000001}, {"lat": -2147483648}, {"lon": 1800000001}, {"lat": 2147483647, "lon": 2147483647}]
)
def test_what_is_not_on_earth_is_left_out(follower: Follower, fields: dict[str, int]) -> None:
    assert follower.tell(target(**fields)) is None


def test_a_vehicle_leads_when_it_is_chosen(follower: Follower) -> None:
    position = mavlink.MAVLink_global_position_int_message(5000, 576300000, 115500000, 0, 0, 300, -400, 0, 65535)
    assert follower.tell(position, system=9, component=1) is None
    follower.desk.parameters.set("FOLL_SYSID", 9)
    state = follower.tell(position, system=9, component=1)
    assert state is not None and (state.north_mps, state.east_mps, state.yaw_rad) == (3.0, -4.0, None)
    position.hdg = 27000
    state = follower.tell(position, system=9, component=1)
    assert state is not None and state.yaw_rad == pytest.approx(-0.5 * math.pi)
    follower.tell(target(), system=9, component=191)
    assert follower.tell(position, system=9, component=1) is None, "its FOLLOW_TARGET says more"
    follower.desk.now_s += 6.0
    assert follower.tell(position, system=9, component=1) is not None


def test_lost_packets_are_counted_by_sender(follower: Follower) -> None:
    follower.tell(target(), system=42)
    follower.tell(target(), system=43)
    losses = []
    for skip in (0, 3, 0, 1):
        state = follower.tell(target(), system=42, skip=skip)
        assert state is not None
        losses.append(state.lost)
    assert losses == [0, 3, 0, 1]
    state = follower.tell(target(), system=43)
    assert state is not None and state.lost == 0


def test_the_module_is_asked_for_its_time_and_its_latency_is_taken_out(follower: Follower) -> None:
    """The module's clock is 1000 s behind ours, every message takes 0.3 s, a question 0.1 s each way."""
    desk = follower.desk
    desk.now_s = 2000.0
    asked = []
    for _ in range(200):
        nav = replace(NAV, t_s=desk.now_s - 0.3 - 1000.0)
        state = follower.tell(follow_target(nav, True, Wish.AUTONOMOUS, 1, True))
        desk.wait(0.1)
        for _peer, message in desk.heard():
            assert (
                message.get_type() == "TIMESYNC"
                and message.tc1 == 0
                and (message.target_system, message.target_component) == (42, 191)
            )
            asked.append(desk.now_s)
            desk.now_s += 0.2
            answer = mavlink.MAVLink_timesync_message(round((desk.now_s - 0.1 - 1000.0) * 1e9), message.ts1, 1, 1)
            follower.tell(answer)
    assert state is not None and state.t_s == pytest.approx(state.heard_s - 0.3, abs=2e-3)
    assert 2 <= len(asked) <= 4, "every ten seconds"


def test_who_never_answers_is_not_asked_for_ever(follower: Follower) -> None:
    desk, asked = follower.desk, 0
    for n in range(3000):
        follower.tell(target(timestamp=1000 + 100 * n), system=255)
        desk.wait(0.1)
        asked += len(desk.heard())
    assert 1 <= asked <= 10


def fuzzed(rng: random.Random) -> Any:
    """A FOLLOW_TARGET of random bytes, or one with a few fields that make no sense."""
    if rng.random() < 0.5:
        cls = mavlink.MESSAGES[mavlink.MAVLINK_MSG_ID_FOLLOW_TARGET]
        values = cls.unpacker.unpack(rng.randbytes(cls.unpacker.size))
        wire = iter(values)
        ordered = {}
        for name, length in zip(cls.ordered_fieldnames, cls.array_lengths, strict=True):
            ordered[name] = [next(wire) for _ in range(length)] if length else next(wire)
        return mavlink.MAVLink_follow_target_message(**ordered)
    odd = lambda: rng.choice([NAN, math.inf, -math.inf, 0.0, -0.0, 3.4e38, -3.4e38, 1e-45, rng.gauss(0.0, 10.0)])  # noqa: E731
    return target(
        timestamp=rng.choice([0, 1, 2**64 - 1, 2**63, rng.randrange(2**64), rng.randrange(10**6)]),
        est_capabilities=rng.randrange(256),
        lat=rng.choice([0, 576300000, 2**31 - 1, -(2**31), rng.randrange(-(2**31), 2**31)]),
        lon=rng.choice([0, 115500000, 2**31 - 1, -(2**31), rng.randrange(-(2**31), 2**31)]),
        vel=(odd(), odd(), odd()),
        attitude_q=(odd(), odd(), odd(), odd()),
        rates=(odd(), odd(), odd()),
        position_cov=(odd(), odd(), odd()),
        custom_state=rng.choice([0, 0x55535603, 0x555356FF | rng.randrange(2**32) << 32, rng.randrange(2**64)]),
    )


def test_ten_thousand_fuzzed_targets_are_borne(follower: Follower) -> None:
    rng = random.Random(20)
    for n in range(10_000):
        follower.desk.now_s += rng.choice([0.0, 0.05, 0.05, 1.0])
        state = follower.tell(
            fuzzed(rng), system=rng.choice([42, 42, 42, 255, rng.randrange(1, 255)]), skip=rng.choice([0, 0, 5, 200])
        )
        follower.service.update(follower.desk.now_s)
        if state is None:
            continue
        numbers = [
            state.t_s,
            state.heard_s,
            *(
                getattr(state, name)
                for name in ("lat_deg", "lon_deg", "north_mps", "east_mps", "yaw_rad", "yaw_rate_radps", "accuracy_m")
            ),
        ]
        assert all(number is None or math.isfinite(number) for number in numbers), (n, state)
        assert state.t_s <= state.heard_s and state.lost >= 0
        assert state.lat_deg is None or (abs(state.lat_deg) <= 90.0 and abs(state.lon_deg or 0.0) <= 180.0)
        assert state.yaw_rad is None or abs(state.yaw_rad) <= math.pi
    assert len(follower.states) > 2000
