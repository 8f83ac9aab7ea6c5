"""Nothing that a peer or a device sends stops the boat, or costs it a plan."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.cli.rig import LockstepRig
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import frame, pack
from companion.mission.plan import PlanKind
from sitl.scenarios.rig import Conditions
from tests.protocol.desk import Desk, of
from tests.protocol.test_qgroundcontrol import item, square

FRAMES = 100_000


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    desk = Desk(tmp_path)
    desk.tick()
    assert desk.upload(square()) == mavlink.MAV_MISSION_ACCEPTED
    yield desk
    assert len(desk.vessel.plans.items(PlanKind.MISSION)) == len(square()), "the plan is still there"
    desk.close()


def broken_frames(seed: int, count: int) -> Iterator[bytes]:
    """Random bytes, truncated frames, flipped bits, stray start marks."""
    source = random.Random(seed)
    good = [
        frame(pack(message), n, 255, 190)
        for n, message in enumerate(
            (
                mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3),
                mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1.0, 0, 0, 0, 0, 0, 0),
                mavlink.MAVLink_mission_count_message(1, 1, 3, 0),
                square()[0],
                mavlink.MAVLink_param_set_message(1, 1, b"DP_BW_SURGE", 0.4, 9),
            )
        )
    ]
    for _ in range(count):
        kind = source.randrange(4)
        data = bytearray(source.choice(good))
        if kind == 0:
            data = bytearray(source.randbytes(source.randrange(1, 40)))
        elif kind == 1:
            del data[source.randrange(1, len(data)) :]
        elif kind == 2:
            data[source.randrange(1, len(data))] ^= 1 << source.randrange(8)
        else:
            data = bytearray([0xFD] * source.randrange(1, 4))
        yield bytes(data)


def test_broken_frames_on_a_link(desk: Desk) -> None:
    batch: list[bytes] = []
    for data in broken_frames(1, FRAMES):
        batch.append(data)
        if len(batch) == 500:
            desk.rig.send(b"".join(batch))
            desk.vessel.serve(desk.rig.now_s)
            desk.rig.receive()
            batch.clear()
    desk.tick(3)
    status = desk.vessel.supervisor.status(desk.rig.now_s)
    assert not status.armed
    assert desk.result(512, 148.0) == mavlink.MAV_RESULT_ACCEPTED, "the next good frame is heard"


def test_random_bytes_on_every_sensor_port(tmp_path: Path) -> None:
    """The devices go on talking in between: their readings must still be found."""
    rig = LockstepRig(Conditions("revolt", seed=5), tmp_path / "log")
    source = random.Random(2)
    for _ in range(100):
        rig.step()
    for _ in range(200):
        for name in ("gnss", "imu", "microcontroller"):
            rig.world.babble(name, b"".join(source.randbytes(source.randrange(1, 30)) for _ in range(FRAMES // 600)))
        rig.step()
    for _ in range(50):
        rig.step()
    tick = rig.vessel.last_tick
    truth = rig.world.truth
    assert tick is not None and tick.nav.position_valid
    assert math.hypot(tick.nav.north_m - truth.north_m, tick.nav.east_m - truth.east_m) < 1.0
    rig.close()


@pytest.mark.parametrize(
    ("items", "result"),
    [
        ([item(0, 16, 0.0, 0.0, math.nan)], {mavlink.MAV_MISSION_INVALID_PARAM1}),
        ([item(0, 16, 0.0, 0.0, -5.0)], {mavlink.MAV_MISSION_INVALID_PARAM1}),
        ([item(0, 4242, 0.0, 0.0)], {mavlink.MAV_MISSION_UNSUPPORTED}),
        ([item(0, 16, 0.0, 0.0, frame=8)], {mavlink.MAV_MISSION_UNSUPPORTED_FRAME}),
        (
            [item(0, 16, 0.0, 0.0), item(1, 177, 0, 0, 12.0, 1.0, frame=2)],
            {mavlink.MAV_MISSION_INVALID_PARAM1, mavlink.MAV_MISSION_INVALID},
        ),
    ],
    ids=["NaN", "negative hold", "unknown command", "unknown frame", "jump to nowhere"],
)
def test_a_broken_mission_is_refused_with_its_code_and_item(desk: Desk, items: list[Any], result: set[int]) -> None:
    assert desk.upload(items) in result
    desk.tick(2)
    assert any("item" in text for text in desk.texts())


def test_coordinates_out_of_range(desk: Desk) -> None:
    north_of_the_pole = item(0, 16, 0.0, 0.0)
    north_of_the_pole.x = 910_000_000
    assert desk.upload([north_of_the_pole]) == mavlink.MAV_MISSION_INVALID_PARAM5_X
    beyond = item(0, 16, 0.0, 0.0)
    beyond.y = 1_810_000_000
    assert desk.upload([beyond]) == mavlink.MAV_MISSION_INVALID_PARAM6_Y


def test_wrong_counts(desk: Desk) -> None:
    refused = desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 20_000, 0))
    assert [a.type for a in of(refused, "MISSION_ACK")] == [mavlink.MAV_MISSION_NO_SPACE]
    desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 4, 0))
    desk.tell(*square()[:2])  # and never the rest
    desk.tick(100)
    assert of(desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 0)), "MISSION_COUNT")[0].count == len(
        square()
    )


def test_odd_commands_get_one_answer_each_and_move_nothing(desk: Desk) -> None:
    """Every command number up to 3000 and odd parameters; reboot and arming apart, which are meant."""
    source = random.Random(3)
    odd = (0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 1e38, 1e-40, 2989.0)
    for number in [n for n in range(3000) if n not in (246, 400)] + [31010, 42424, 65535]:
        params = [source.choice(odd) for _ in range(7)]
        acks = of(desk.command(number, *params), "COMMAND_ACK")
        assert [ack.command for ack in acks] == [number], number
    for tick in range(5):
        desk.tick()
        assert desk.vessel.last_tick is not None, tick
        assert all(thruster.throttle == 0.0 for thruster in desk.vessel.last_tick.command.thrusters)
    assert not any("not handled" in text for text in desk.texts()), desk.texts()
