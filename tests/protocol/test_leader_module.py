"""The module on a lead boat and its follower, both whole and in lockstep: every byte between them is framed, sent and
parsed."""

from __future__ import annotations

import csv
import math
import random
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.analysis.log_reader import open_log
from companion.analysis.rerun import rerun
from companion.app import load_vessel
from companion.clock import SimulatedClock
from companion.core.decision import ModeId
from companion.core.readings import LeaderState, Wish
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer
from companion.io.mavlink.wire.links import MemoryLink
from companion.leader_module.app import LeaderSurroundings, build_leader
from companion.leader_module.config import LeaderConfig
from sitl.magnetometer import with_magnetometer
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions
from tests.protocol.desk import Sender
from tests.protocol.lead_boat_module import FRAME, NoDisplay, Pair, along, circle

PX4_FOLLOW, PX4_MANUAL, PX4_OFFBOARD = 0x08040000, 0x00010000, 0x00060000


class Heard:
    """What the follower is told, and the packets in the air."""

    def __init__(self, pair: Pair) -> None:
        self.states: list[LeaderState] = []
        self.up, self.down = Framer(), Framer()
        self.sent: list[tuple[float, bool, Any]] = []
        supervisor, pass_on = pair.vessel.supervisor, pair.vessel.supervisor.leader_heard

        def leader_heard(state: LeaderState) -> None:
            self.states.append(state)
            pass_on(state)

        supervisor.leader_heard = leader_heard  # type: ignore[method-assign]
        air = pair.air

        def listening(t_s: float, up: bool, data: bytes) -> bytes:
            data = air(t_s, up, data)
            self.sent += [(t_s, up, message) for message in (self.up if up else self.down).feed(data)]
            return data

        pair.air = listening

    def kinds(self, up: bool) -> Counter[str]:
        return Counter(message.get_type() for _, way, message in self.sent if way == up)


@pytest.fixture
def pair(tmp_path: Path) -> Iterator[Pair]:
    made = Pair(tmp_path, circle)
    yield made
    made.close()


def under_way(pair: Pair) -> None:
    """Armed, in Follow."""
    pair.run(8.0)
    assert pair.vessel.supervisor.arm(pair.now_s).accepted
    assert pair.vessel.supervisor.request_mode(ModeId.FOLLOW, pair.now_s).accepted


def test_both_ways_take_less_than_2000_bytes_a_second(pair: Pair) -> None:
    """On a narrow line, over half a minute of Follow, texts and questions for the time included."""
    under_way(pair)
    heard = Heard(pair)
    pair.bytes_up = pair.bytes_down = 0
    pair.run(30.0)
    up, down = pair.bytes_up / 30.0, pair.bytes_down / 30.0
    print(f"to the follower {up:.0f} bytes/s, back {down:.0f}, together {up + down:.0f}")
    assert up + down < 2000.0
    assert heard.kinds(True)["FOLLOW_TARGET"] == pytest.approx(600, abs=1)
    assert up == pytest.approx(105 + 19 * 92 + 21 + 0.1 * 30, abs=4.0)
    back = heard.kinds(False)
    assert {kind: back[kind] for kind in ("HEARTBEAT", "GLOBAL_POSITION_INT", "DEBUG_VECT")} == {
        "HEARTBEAT": 30, "GLOBAL_POSITION_INT": 30, "DEBUG_VECT": 30,
    }  # fmt: skip
    assert set(back) <= {"HEARTBEAT", "GLOBAL_POSITION_INT", "DEBUG_VECT", "TIMESYNC", "STATUSTEXT"}


def test_sticks_take_less_than_2000_too_and_positions_give_way(pair: Pair) -> None:
    pair.run(8.0)
    sender = Sender(255)
    set_mode = mavlink.MAVLink_set_mode_message(42, 1, PX4_OFFBOARD)
    pair.local.to_vessel(sender.packed(set_mode))
    heard = Heard(pair)
    pair.bytes_up = pair.bytes_down = 0
    for n in range(400):
        if n % 2 == 0:
            pair.local.to_vessel(sender.packed(mavlink.MAVLink_manual_control_message(42, 300, 0, 0, -200, 0)))
        pair.step()
    kinds = heard.kinds(True)
    print(f"with sticks {(pair.bytes_up + pair.bytes_down) / 20.0:.0f} bytes/s; {dict(kinds)}")
    assert (pair.bytes_up + pair.bytes_down) / 20.0 < 2000.0
    assert kinds["MANUAL_CONTROL"] == pytest.approx(200, abs=2) and kinds["FOLLOW_TARGET"] == pytest.approx(200, abs=2)
    sticks = [m for _, _, m in heard.sent if m.get_type() == "MANUAL_CONTROL"]
    assert (sticks[-1].target, sticks[-1].x, sticks[-1].z, sticks[-1].r) == (1, 300, 300, -200)
    heard.sent.clear()
    pair.display.press("a")
    pair.run(2.0)
    assert heard.kinds(True)["MANUAL_CONTROL"] == 0 and heard.kinds(True)["FOLLOW_TARGET"] == 40


def test_without_thrift_every_message_is_whole(tmp_path: Path) -> None:
    pair = Pair(tmp_path, circle, more="")
    heard = Heard(pair)
    pair.run(5.0)
    assert all(m.est_capabilities for t_s, _, m in heard.sent if m.get_type() == "FOLLOW_TARGET" and t_s > 3.0)
    pair.close()


@pytest.mark.parametrize(
    ("path", "most_m"), [(along(8.0, 45.0, 20.0, 20.0), 0.35), (circle, 1.3)], ids=["straight", "turn"]
)
def test_what_the_follower_knows_is_where_the_leader_is(tmp_path: Path, path: Any, most_m: float) -> None:
    """The receiver is perfect. What is left: half a step of latency that lockstep feigns and, in a turn without a gyro,
    the lag of the filter on the lead boat."""
    pair = Pair(tmp_path, path)
    heard = Heard(pair)
    pair.run(20.0)
    errors = []
    for state in heard.states:
        if state.heard_s > 8.0:
            assert state.lat_deg is not None and state.lon_deg is not None and state.yaw_rad is not None
            north_m, east_m, _, _ = path(state.t_s)
            told = FRAME.to_ned(state.lat_deg, state.lon_deg)
            errors.append(math.hypot(told[0] - north_m, told[1] - east_m))
    pair.close()
    print(f"largest error {max(errors):.2f} m")
    assert len(errors) > 200 and max(errors) < most_m


def test_keys_choose_and_choose_again(pair: Pair) -> None:
    heard = Heard(pair)
    asked = []
    for key in ("", "m", "a", "a", "r", "x", "q"):
        pair.display.press(key)
        pair.module.serve(pair.now_s)
        pair.run(0.5)
        asked.append((heard.states[-1].wish, heard.states[-1].presses))
    assert asked == [
        (Wish.NONE, 0),
        (Wish.MANUAL, 1),
        (Wish.AUTONOMOUS, 2),
        (Wish.AUTONOMOUS, 3),
        (Wish.REMOTE, 4),
        (Wish.REMOTE, 4),
        (Wish.REMOTE, 4),
    ]
    assert "asked for: Autonomous" in pair.display.said


def test_a_station_on_the_lead_boat_chooses_too(pair: Pair) -> None:
    pair.run(8.0)
    sender, framer = Sender(255), Framer()

    def ask(message: Any) -> list[Any]:
        pair.local.from_vessel()
        pair.local.to_vessel(sender.packed(message))
        pair.run(0.2)
        return framer.feed(pair.local.from_vessel())

    def command(number: int, *params: float, target: int = 42) -> list[int]:
        padded = (*params, *(0.0 for _ in range(7 - len(params))))
        answers = ask(mavlink.MAVLink_command_long_message(target, 1, number, 0, *padded))
        return [m.result for m in answers if m.get_type() == "COMMAND_ACK"]

    (beat,) = (m for m in ask(mavlink.MAVLink_set_mode_message(42, 1, PX4_FOLLOW)) if m.get_type() == "HEARTBEAT")
    assert (beat.get_srcSystem(), beat.custom_mode) == (42, PX4_FOLLOW)
    assert (pair.module.crew.wish, pair.module.crew.presses) == (Wish.AUTONOMOUS, 1)
    assert command(176, 1, 1, 0) == [0] and pair.module.crew.wish is Wish.MANUAL
    assert command(176, 1, 4, 8) == [0] and (pair.module.crew.wish, pair.module.crew.presses) == (Wish.AUTONOMOUS, 3)
    assert command(176, 1, 4, 3) == [2] and command(176, 1, math.nan, 0) == [2] and command(400, 1) == [3]
    assert command(176, 1, 1, 0, target=1) == [], "for another"
    ask(mavlink.MAVLink_set_mode_message(7, 1, PX4_MANUAL))
    assert (pair.module.crew.wish, pair.module.crew.presses) == (Wish.AUTONOMOUS, 3)


def test_the_counters_at_both_ends_tell_of_the_link(pair: Pair) -> None:
    under_way(pair)
    pair.run(5.0)
    module, supervisor = pair.module, pair.vessel.supervisor
    follower_counter = lambda: supervisor.status(pair.now_s).leader.counter  # type: ignore[union-attr]  # noqa: E731
    assert (module.link.counter, follower_counter()) == (0, 0)
    framers = {True: Framer(), False: Framer()}
    rng, loss = random.Random(8), 0.2

    def lossy(t_s: float, up: bool, data: bytes) -> bytes:
        return b"".join(bytes(m.get_msgbuf()) for m in framers[up].feed(data) if rng.random() >= loss)

    pair.air = lossy
    pair.run(15.0)
    assert module.link.counter is not None and module.link.counter <= 25 and follower_counter() <= 10
    loss = 0.9
    pair.run(10.0)
    assert module.link.counter > 30 and follower_counter() > 30
    pair.air = lambda t_s, up, data: data if not up else b""  # only the way to the follower is cut
    pair.run(6.0)
    assert module.link.counter == 40 and follower_counter() == 40
    pair.air = lambda t_s, up, data: data
    pair.run(8.0)
    assert (module.link.counter, follower_counter()) == (0, 0)
    pair.air = lambda t_s, up, data: b""
    pair.run(1.0)
    assert follower_counter() == pytest.approx(20, abs=2)
    pair.run(7.0)
    assert module.link.counter == 40
    assert "follower silent for" in pair.display.lines[-1]


def test_half_of_all_packets_lost_leaves_the_leader_known(pair: Pair) -> None:
    framers, rng = {True: Framer(), False: Framer()}, random.Random(3)
    pair.air = lambda t_s, up, data: b"".join(
        bytes(m.get_msgbuf()) for m in framers[up].feed(data) if rng.random() < 0.5
    )
    heard = Heard(pair)
    pair.run(20.0)
    late = [state for state in heard.states if state.heard_s > 10.0]
    assert len(late) == pytest.approx(100, abs=25)
    assert all(
        state.yaw_rad is not None and state.accuracy_m is not None and 0.0 <= state.heard_s - state.t_s < 0.11
        for state in late
    )
    assert sum(state.lost for state in late) == pytest.approx(105, abs=28)


def test_a_lost_fix_is_told_within_two_tenths_of_a_second(pair: Pair) -> None:
    heard = Heard(pair)
    pair.run(10.0)
    for how in ("says so", "silent"):
        assert heard.states[-1].lat_deg is not None
        stream = pair.streams.streams["gnss"]
        began_s = pair.now_s
        pair.fix, stream.plugged = how != "says so", how == "says so"
        pair.run(1.0)
        placed_s = max(state.heard_s for state in heard.states if state.lat_deg is not None)
        assert placed_s - began_s <= 0.2, how
        assert pair.display.lines[-1].startswith("NO FIX")
        pair.fix, stream.plugged = True, True
        pair.run(3.0)
    assert any("no fix" in text for text in pair.display.said)


def test_nothing_that_a_peer_sends_stops_the_module(pair: Pair) -> None:
    pair.run(3.0)
    rng = random.Random(1)
    known = [m for m in mavlink.MESSAGES.values() if m.id not in (0,)]
    for n in range(1500):
        cls = rng.choice(known)
        junk = _random_message(cls, rng)
        sender = Sender(rng.choice([1, 1, 255, 42]), rng.choice([1, 190]))
        link = pair.local if n % 2 else pair.far
        link.to_vessel(sender.packed(junk) if junk is not None else rng.randbytes(40))
        if n % 10 == 0:
            pair.step()
    heard = Heard(pair)
    pair.run(2.0)
    assert heard.kinds(True)["FOLLOW_TARGET"] == pytest.approx(
        40, abs=21
    )  # every second one if the junk has asked for remote control
    assert not [text for text in pair.display.said if "not handled" in text]


def _random_message(cls: Any, rng: random.Random) -> Any:
    values = cls.unpacker.unpack(rng.randbytes(cls.unpacker.size))
    at = [sum(cls.lengths[:n]) for n in range(len(cls.lengths))]  # of each field on the wire
    lengths = [cls.lengths[n] for n in cls.orders]
    fields = [
        values[at[n]] if size == 1 else list(values[at[n] : at[n] + size])
        for n, size in zip(cls.orders, lengths, strict=True)
    ]
    try:
        return cls(*fields)
    except (TypeError, UnicodeDecodeError, ValueError):
        return None


def test_the_follower_streams_nothing_else_there_but_answers(pair: Pair) -> None:
    pair.run(5.0)
    heard, sender = Heard(pair), Sender(255)
    pair.lead.to_vessel(sender.packed(mavlink.MAVLink_param_request_read_message(1, 1, b"FLW_TGT_DST", -1)))
    pair.lead.to_vessel(sender.packed(mavlink.MAVLink_command_long_message(1, 1, 512, 0, 33, 0, 0, 0, 0, 0, 0)))
    pair.lead.to_vessel(sender.packed(mavlink.MAVLink_command_long_message(1, 1, 511, 0, 30, 200000, 0, 0, 0, 0, 0)))
    pair.run(4.0)
    kinds = heard.kinds(False)
    assert kinds["PARAM_VALUE"] == 1 and kinds["COMMAND_ACK"] == 2 and kinds["GLOBAL_POSITION_INT"] == 5
    assert kinds["ATTITUDE"] == pytest.approx(20, abs=1), "asked for, so it is streamed"
    assert set(kinds) <= {
        "PARAM_VALUE",
        "COMMAND_ACK",
        "ATTITUDE",
        "HEARTBEAT",
        "GLOBAL_POSITION_INT",
        "DEBUG_VECT",
        "TIMESYNC",
        "STATUSTEXT",
    }


def test_ground_stations_see_the_leader_and_the_link(pair: Pair) -> None:
    under_way(pair)
    framer = Framer()
    pair.station.from_vessel()
    pair.run(3.0)
    seen = framer.feed(pair.station.from_vessel())
    values = {m.name: m.value for m in seen if m.get_type() == "NAMED_VALUE_FLOAT"}
    assert values["lead_link"] == 0.0 and 1.0 < values["lead_gap"] < 200.0
    vessels = [m for m in seen if m.get_type() == "AIS_VESSEL"]
    assert len(vessels) == pytest.approx(3, abs=1) and vessels[-1].MMSI == 42 and vessels[-1].name == "LEADER"
    north_m, east_m, _, _ = circle(pair.now_s)
    at = FRAME.to_ned(vessels[-1].lat * 1e-7, vessels[-1].lon * 1e-7)
    assert math.hypot(at[0] - north_m, at[1] - east_m) < 15.0
    assert not [m for m in seen if m.get_type() == "DEBUG_VECT"]


def test_the_log_can_be_read_again(tmp_path: Path) -> None:
    pair = Pair(tmp_path, along(5.0, 90.0, 20.0, 0.0))
    pair.run(6.0)
    pair.display.press("m")
    pair.run(2.0)
    pair.close()
    with (tmp_path / "leader" / "module.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 160
    last = rows[-1]
    assert (last["wish"], last["presses"], last["follower_mode"], last["link_counter"]) == (
        "MANUAL",
        "1",
        ModeId.MANUAL.value,
        "0",
    )
    assert FRAME.to_ned(float(last["lat_deg"]), float(last["lon_deg"])) == pytest.approx((20.0, 5.0 * 7.95), abs=0.5)
    assert float(last["gap_m"]) == pytest.approx(math.hypot(20.0, 5.0 * 7.95), abs=3.0)
    assert "asked for: Manual" in (tmp_path / "leader" / "events.csv").read_text(encoding="utf-8")


def test_a_followed_leader_is_replayed_to_the_last_bit(pair: Pair, tmp_path: Path) -> None:
    """Clocks, questions for the time and losses included: all of it comes from the packets in the log."""
    framers, rng = {True: Framer(), False: Framer()}, random.Random(6)
    pair.air = lambda t_s, up, data: b"".join(
        bytes(m.get_msgbuf()) for m in framers[up].feed(data) if rng.random() < 0.8
    )
    pair.run(8.0)
    sender = Sender(255)
    pair.station.to_vessel(sender.packed(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)))
    pair.step()
    pair.station.to_vessel(sender.packed(mavlink.MAVLink_set_mode_message(1, 1, PX4_FOLLOW)))
    pair.run(8.0)
    assert pair.vessel.supervisor.status(pair.now_s).mode is ModeId.FOLLOW
    pair.close()
    difference = rerun(open_log(tmp_path / "follower"), tmp_path / "again")
    assert difference.ticks == 321 and difference.differing == 0, difference


def test_a_module_with_an_inertial_sensor_tells_heading_and_turn(tmp_path: Path) -> None:
    """Its own AHRS, from the bytes of an emulated receiver and an emulated sensor with a magnetometer, on a boat that
    is turned by hand."""
    boat = with_magnetometer(load_vessel("rescuerunner"))
    world, clock, far = World(boat, WorldConditions(seed=2)), SimulatedClock(EPOCH_UNIX_NS), MemoryLink("memory:far")
    config = LeaderConfig("lead", 42, ("memory:far",), boat.sensors)
    module = build_leader(config, LeaderSurroundings(clock, world, [far], [], NoDisplay()))
    framer, states = Framer(), []
    for n in range(400):
        clock.wait(0.05 * n, ())
        if n >= 200:
            world.set_state(0.0, 0.0, 0.2 * (0.05 * n - 10.0), 0.0, 0.0, 0.2)
        world.advance(clock.now_s())
        module.tick(clock.now_s())
        states += [m for m in framer.feed(far.from_vessel()) if m.get_type() == "FOLLOW_TARGET"]
    module.close()
    assert states[-1].est_capabilities == 11 and 0.1 < states[-1].position_cov[0] < 5.0
    turned = 0.2 * (0.05 * 399 - 10.0)
    for state, yaw_rad in ((states[199], 0.0), (states[-1], turned)):
        w, _, _, z = state.attitude_q
        error_deg = math.degrees(math.remainder(2.0 * math.atan2(z, w) - yaw_rad, math.tau))
        print(f"heading off by {error_deg:.1f} deg")
        assert abs(error_deg) < 3.0
    assert states[-1].rates[2] == pytest.approx(0.2, abs=0.03)


@pytest.mark.parametrize("same", [True, False])
def test_a_module_with_the_same_key_is_followed_and_no_other(tmp_path: Path, same: bool) -> None:
    key, other = bytes(range(32)), bytes(range(1, 33))
    pair = Pair(tmp_path, circle, keys=(key, key if same else other))
    pair.run(8.0)
    followed = pair.vessel.supervisor.status(pair.now_s).leader is not None
    heard = pair.module.link.follower.heard_s is not None
    pair.close()
    assert followed is same and heard is same


def test_a_fault_of_the_program_does_not_end_the_module(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    """The follower goes on by what the lead boat's module still sends."""
    traces: list[str] = []
    pair.module.containment.report = traces.append
    under_way(pair)

    def failing(*_: Any) -> Any:
        raise ZeroDivisionError

    with monkeypatch.context() as fault:
        fault.setattr(pair.module, "cycle", failing)
        pair.run(0.5)
    heard = Heard(pair)
    pair.run(3.0)
    assert heard.states and pair.vessel.supervisor.status(pair.now_s).mode is ModeId.FOLLOW
    assert len(traces) == 1
