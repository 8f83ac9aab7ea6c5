"""Cameras and gimbals on the links: what is passed on to them, what comes back to who asked, and what all hear of
pictures. The components speak by pymavlink."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega

from companion.config.payload import CameraConfig
from companion.core.payload import Forward, PayloadPart, Shot
from companion.io.mavlink.wire import messages as mavlink
from tests.unit.io.mavlink.hub.conftest import FakeVessel, Rig

Named = Callable[[Sequence[Any], str], list[Any]]
ACCEPTED, REJECTED, DENIED, UNSUPPORTED, FAILED, IN_PROGRESS = 0, 1, 2, 3, 4, 5
GIMBAL, CAMERA = 26, 30
PITCH = (1000, -45.0, 0.0, math.nan, math.nan, 0.0, 0.0, 0.0)
LINKED = CameraConfig("linked", "mavlink", component=100)


class Part:
    """A component on the second link, as its maker wrote it."""

    def __init__(self, rig: Rig, component: int, kind: int, system: int = 1) -> None:
        self.rig, self.kind = rig, kind
        self._link = rig.desks[1].link
        self._codec = ardupilotmega.MAVLink(None, srcSystem=system, srcComponent=component)
        self._codec.robust_parsing = True
        self.heard: list[Any] = []

    def send(self, message: Any) -> None:
        self._link.to_vessel(message.pack(self._codec))
        self.rig.serve()

    def beat(self) -> None:
        self.send(ardupilotmega.MAVLink_heartbeat_message(self.kind, 8, 0, 0, 4, 3))

    def commands(self) -> list[Any]:
        parsed = self._codec.parse_buffer(self._link.from_vessel()) or []
        return [message for message in parsed if message.get_type() in ("COMMAND_LONG", "COMMAND_INT")]

    def answer(self, command: int, result: int, **more: int) -> None:
        to_the_boat = {"target_system": 1, "target_component": 1}
        self.send(ardupilotmega.MAVLink_command_ack_message(command, result, **to_the_boat, **more))


def results(messages: Sequence[Any]) -> list[tuple[int, int]]:
    return [(message.command, message.result) for message in messages if message.get_type() == "COMMAND_ACK"]


@pytest.fixture
def rig(make_rig: type[Rig]) -> Rig:
    return make_rig(["memory:a", "memory:b"])


@pytest.fixture
def gimbal(rig: Rig) -> Part:
    part = Part(rig, 154, GIMBAL)
    part.beat()
    part.commands()
    return part


def test_a_command_goes_to_the_gimbal_and_its_answer_to_who_asked(rig: Rig, gimbal: Part) -> None:
    assert results(rig.command(*PITCH)) == []
    (command,) = gimbal.commands()
    assert (command.target_system, command.target_component, command.get_srcComponent()) == (1, 154, 1)
    assert (command.command, command.param1) == (1000, -45.0) and math.isnan(command.param3)
    gimbal.answer(1000, ACCEPTED)
    assert results(rig.desk.hear()) == [(1000, ACCEPTED)]


@pytest.mark.parametrize("result", [REJECTED, DENIED, UNSUPPORTED, FAILED])
def test_a_gimbals_refusal_is_passed_back(rig: Rig, gimbal: Part, named: Named, result: int) -> None:
    rig.command(*PITCH)
    gimbal.answer(1000, result)
    heard = rig.desk.hear()
    assert results(heard) == [(1000, result)]
    assert [m.text for m in named(heard, "STATUSTEXT")] == ["DO_GIMBAL_MANAGER_PITCHYAW: gimbal 154 refuses"]


def test_progress_is_passed_back_and_waited_for(rig: Rig, gimbal: Part) -> None:
    rig.command(*PITCH)
    gimbal.answer(1000, IN_PROGRESS, progress=40)
    assert results(rig.desk.hear()) == [(1000, IN_PROGRESS)]
    gimbal.beat()
    rig.run(3.0)
    gimbal.answer(1000, ACCEPTED)
    assert results(rig.desk.hear()) == [(1000, ACCEPTED)]


def test_a_place_is_passed_on_to_the_last_digit(rig: Rig, gimbal: Part) -> None:
    rig.command_int(195, (0.0, 0.0, 0.0, 0.0), 634_389_123, 103_990_457, 2.5, the_frame=5)
    (command,) = gimbal.commands()
    assert command.get_type() == "COMMAND_INT" and command.frame == 5
    assert (command.x, command.y, command.z) == (634_389_123, 103_990_457, 2.5)


def test_a_gimbal_that_does_not_answer(rig: Rig, gimbal: Part, named: Named) -> None:
    rig.command(*PITCH)
    rig.run(0.9)
    gimbal.beat()
    assert [command.confirmation for command in gimbal.commands()] == [0, 1]
    rig.run(0.3)
    heard = rig.desk.hear()
    assert results(heard) == [(1000, FAILED)]
    said = "".join(message.text for message in named(heard, "STATUSTEXT"))
    assert "DO_GIMBAL_MANAGER_PITCHYAW: gimbal 154 does not answer" in said


def test_a_repetition_waits_for_the_same_answer(rig: Rig, gimbal: Part) -> None:
    rig.command(*PITCH)
    rig.command(*PITCH)
    assert len(gimbal.commands()) == 1
    gimbal.answer(1000, ACCEPTED)
    assert results(rig.desk.hear()) == [(1000, ACCEPTED)]
    rig.desk.system = 77
    assert results(rig.command(*PITCH)) == []


def test_other_angles_go_on_while_the_ones_before_wait_for_their_answer(rig: Rig, gimbal: Part) -> None:
    rig.command(*PITCH)
    rig.command(PITCH[0], -30.0, *PITCH[2:])
    assert [(command.param1, command.confirmation) for command in gimbal.commands()] == [(-45.0, 0), (-30.0, 0)]
    rig.run(0.5)
    assert [(command.param1, command.confirmation) for command in gimbal.commands()] == [(-30.0, 1)]
    gimbal.answer(1000, ACCEPTED)
    assert results(rig.desk.hear()) == [(1000, ACCEPTED)]


@pytest.mark.parametrize("number", [195, 197, 201, 204, 205, 220, 1000, 1001])
def test_without_a_gimbal_it_is_refused_with_the_reason(rig: Rig, named: Named, number: int) -> None:
    Part(rig, 154, GIMBAL, system=9).beat()  # that of another vehicle
    heard = rig.command(number)
    assert results(heard) == [(number, REJECTED)]
    (text,) = (message.text for message in named(heard, "STATUSTEXT"))
    assert text.endswith("no gimbal on a link")


def test_one_that_falls_silent_is_forgotten(rig: Rig, gimbal: Part) -> None:
    rig.run(6.0)
    rig.desk.hear()
    assert results(rig.command(*PITCH)) == [(1000, REJECTED)]
    gimbal.beat()
    assert results(rig.command(*PITCH)) == []


def test_a_gimbal_may_be_named(rig: Rig, gimbal: Part) -> None:
    second = Part(rig, 171, GIMBAL)
    second.beat()
    second.commands()
    rig.command(1000, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 171.0)
    assert [command.target_component for command in second.commands()] == [171]
    assert results(rig.command(1000, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 172.0)) == [(1000, REJECTED)]


def test_a_command_of_a_mission(rig: Rig, gimbal: Part) -> None:
    action = Forward(PayloadPart.GIMBAL, 205, (-90.0, 0, 0, 0, 0, 0, 2.0), None, 0, 7)
    rig.tick(forwards=(action,))
    assert [(c.command, c.param1, c.param7) for c in gimbal.commands()] == [(205, -90.0, 2.0)]
    gimbal.answer(205, DENIED)
    assert [event.text for event in rig.vessel.events.drain()] == ["Item 8 DO_MOUNT_CONTROL: gimbal 154 refuses"]
    rig.run(6.0)
    rig.tick(forwards=(action,))
    assert any("gimbal is no longer heard" in event.text for event in rig.vessel.events.drain())


SHOT = Shot(5.0, 1, "linked", 3, 4, 63.44, 10.4, 2.0, 0.01, -0.02, -1.0, 0.8, 0.05, 0.01)


def test_pictures_are_told_to_all(rig: Rig) -> None:
    tick = rig.tick(shots=(SHOT,))
    codec = ardupilotmega.MAVLink(None)
    for desk in rig.desks:
        heard = {m.get_type(): m for m in codec.parse_buffer(desk.link.from_vessel()) or []}
        feedback, trigger = heard["CAMERA_FEEDBACK"], heard["CAMERA_TRIGGER"]
        assert trigger.seq == 4 and trigger.time_usec == feedback.time_usec == tick.time_unix_ns // 1000
        assert (feedback.lat, feedback.lng, feedback.img_idx, feedback.cam_idx) == (634_400_000, 104_000_000, 3, 0)
        assert (feedback.target_system, feedback.alt_msl, feedback.alt_rel) == (1, 2.0, 1.0)
        assert feedback.yaw == pytest.approx(360.0 - math.degrees(1.0), abs=1e-4)
        assert feedback.roll == pytest.approx(math.degrees(0.01), abs=1e-6)


def test_a_picture_without_a_position_has_no_place_on_the_map(rig: Rig, named: Named) -> None:
    rig.tick(shots=(replace(SHOT, lat_deg=math.nan, lon_deg=math.nan),))
    heard = rig.desk.hear()
    assert len(named(heard, "CAMERA_TRIGGER")) == 1 and named(heard, "CAMERA_FEEDBACK") == []


@pytest.fixture
def linked(make_rig: type[Rig], monkeypatch: pytest.MonkeyPatch) -> Rig:
    monkeypatch.setattr(FakeVessel, "cameras", (LINKED,))
    return make_rig(["memory:a", "memory:b"])


def test_a_camera_on_a_link_is_told_to_take_each_picture(linked: Rig, named: Named) -> None:
    camera = Part(linked, 100, CAMERA)
    camera.beat()
    camera.commands()
    linked.tick(shots=(replace(SHOT, component=100),))
    (command,) = camera.commands()
    assert (command.command, command.param2, command.param3, command.param4) == (2000, 0.0, 1.0, 3.0)
    assert len(named(linked.desk.hear(), "CAMERA_FEEDBACK")) == 1
    camera.answer(2000, DENIED)
    assert [event.text for event in linked.vessel.events.drain()] == ["Camera 100 refuses to take pictures"]


def test_a_camera_that_tells_of_its_pictures_is_not_spoken_for(linked: Rig, named: Named) -> None:
    """QGroundControl draws a point for CAMERA_FEEDBACK and for CAMERA_IMAGE_CAPTURED."""
    camera = Part(linked, 100, CAMERA)
    camera.beat()
    captured = ardupilotmega.MAVLink_camera_image_captured_message(
        1, 1, 0, 634400000, 104000000, 0, 0, [1, 0, 0, 0], 1, 1, b""
    )
    camera.send(captured)
    linked.desk.hear()
    linked.tick(shots=(replace(SHOT, component=100),))
    heard = linked.desk.hear()
    assert named(heard, "CAMERA_FEEDBACK") == [] and len(named(heard, "CAMERA_TRIGGER")) == 1


def test_commands_for_pictures(linked: Rig, named: Named) -> None:
    heard = linked.command(2000, 0.0, 0.0, 1.0, 1.0)
    assert results(heard) == [(2000, REJECTED)]
    assert [m.text for m in named(heard, "STATUSTEXT")] == ["Camera linked (component 100) is not heard"]
    camera = Part(linked, 100, CAMERA)
    camera.beat()
    for command in (
        (2000, 0.0, 0.0, 1.0, 1.0),
        (203, 0.0, 0.0, 0.0, 0.0, 1.0),
        (206, 5.0, 0.0, 1.0),
        (214, 1000.0),
        (2003, 0.0, -1.0, -1.0),
        (2001,),
    ):
        assert results(linked.command(*command)) == [(command[0], ACCEPTED)]
    assert results(linked.command(206, -5.0)) == [(206, DENIED)]
    assert results(linked.command(2000, 4.0, 0.0, 1.0)) == [(2000, DENIED)]
    assert camera.commands() == []  # a boat that does not tick takes none


def test_what_a_camera_can_beyond_pictures_is_passed_on(linked: Rig) -> None:
    camera = Part(linked, 100, CAMERA)
    camera.beat()
    camera.commands()
    for number in (530, 531, 532, 2500, 2501, 200):
        linked.command(number, 0.0, 1.0)
        assert [command.command for command in camera.commands()] == [number]
        camera.answer(number, ACCEPTED)
        assert results(linked.desk.hear()) == [(number, ACCEPTED)]


def test_without_a_camera_every_command_is_refused_with_a_reason(rig: Rig, named: Named) -> None:
    texts = []
    for number, *params in ((203, 0, 0, 0, 0, 1), (206, 5), (214, 1000), (2000, 0, 0, 1), (2001,), (2003, 1)):
        heard = rig.command(number, *map(float, params))
        assert results(heard) == [(number, DENIED)]
        texts += [m.text for m in named(heard, "STATUSTEXT")]
    assert texts == ["No camera: add [[camera]] to the vessel file"], "the same refusal is said once in half a minute"


def test_the_numbers_are_known_to_mavlink() -> None:
    assert mavlink.MAV_CMD_DO_SET_CAM_TRIGG_DIST == 206 and mavlink.MAV_CMD_IMAGE_START_CAPTURE == 2000
