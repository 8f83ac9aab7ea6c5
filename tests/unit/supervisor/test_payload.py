"""Cameras of a sailing boat: what takes the picture, where it says that it was, and what it says when it cannot."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.config.outputs import RelayConfig, ServoConfig
from companion.config.payload import CameraConfig
from companion.config.vessel import VesselConfig
from companion.core.decision import ModeId, Result, Severity
from companion.core.payload import Forward, PayloadPart
from companion.mission.plan import PlanItem
from companion.mission.tasks import ByDistance, ByTime, StopPictures, TakePicture, TriggerControl
from tests.unit.conftest import Boat

BELOW = CameraConfig("below", "relay", relay="shutter", interval_s=0.5)
AHEAD = CameraConfig("ahead", "servo", servo="finger", press_us=1900.0, x_m=1.0)
LINKED = CameraConfig("linked", "mavlink", component=100)


def do(command: int, *params: float) -> PlanItem:
    padded = (*params, *(0.0 for _ in range(4 - len(params))))
    return PlanItem(0, command, 2, *padded, 0, 0, 0.0)


@pytest.fixture
def fitted(revolt: VesselConfig) -> Callable[..., VesselConfig]:
    def fit(*cameras: CameraConfig, while_disarmed: bool = True) -> VesselConfig:
        bridge = replace(revolt.actuators[0], servos=("finger",), relays=("shutter",))
        return replace(
            revolt,
            servos=(ServoConfig("finger", rest_us=1100.0, while_disarmed=while_disarmed),),
            relays=(RelayConfig("shutter", while_disarmed=while_disarmed),),
            actuators=(bridge,),
            cameras=cameras,
        )

    return fit


@pytest.fixture
def boat(make_boat: Callable[..., Boat], fitted: Callable[..., VesselConfig]) -> Boat:
    return make_boat(fitted(BELOW, AHEAD))


def begin(boat: Boat) -> None:
    boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    assert boat.supervisor.arm(boat.now_s).accepted


def test_a_relay_closes_and_a_servo_presses_for_a_moment(boat: Boat) -> None:
    assert boat.supervisor.payload.request(TakePicture(), boat.now_s).accepted
    boat.step()
    assert boat.auxiliary.relays == (True,) and boat.auxiliary.servos_us == (1900.0,)
    assert [(shot.name, shot.camera, shot.number, shot.count) for shot in boat.shots] == [
        ("below", 1, 1, 1),
        ("ahead", 2, 1, 2),
    ]
    boat.step(0.3)
    assert boat.auxiliary.relays == (False,) and boat.auxiliary.servos_us == (1100.0,)
    assert len(boat.shots) == 2 and "auxiliary" not in boat.names()


def test_one_of_several_cameras(boat: Boat) -> None:
    assert boat.supervisor.payload.request(TakePicture(2), boat.now_s).accepted
    boat.step()
    assert [shot.name for shot in boat.shots] == ["ahead"]
    outcome = boat.supervisor.payload.request(TakePicture(3), boat.now_s)
    assert outcome.result is Result.DENIED and outcome.reason == "No camera 3: this boat has 1 to 2"


def test_a_geotag_is_of_the_lens(boat: Boat) -> None:
    boat.nav = replace(boat.nav, yaw_rad=math.pi / 2.0, roll_rad=0.1, altitude_m=3.0, position_accuracy_m=0.4)
    boat.supervisor.payload.request(TakePicture(2), boat.now_s)
    boat.step()
    (shot,) = boat.shots
    north_m, east_m = boat.frame.to_ned(shot.lat_deg, shot.lon_deg)
    assert (north_m, east_m) == pytest.approx((0.0, 1.0), abs=1e-6)
    assert (shot.yaw_rad, shot.roll_rad, shot.altitude_m) == pytest.approx((math.pi / 2.0, 0.1, 3.0))
    assert shot.position_accuracy_m == 0.4 and shot.t_s == boat.now_s


def test_without_a_position_the_picture_has_none(boat: Boat) -> None:
    boat.nav = replace(boat.nav, position_valid=False)
    boat.supervisor.payload.request(TakePicture(1), boat.now_s)
    boat.step()
    assert math.isnan(boat.shots[0].lat_deg)


def test_a_repeated_request_takes_one_picture(boat: Boat) -> None:
    for sequence in (5, 5, 6):
        assert boat.supervisor.payload.request(TakePicture(1, sequence), boat.now_s).accepted
    boat.step(3.0)
    assert len(boat.shots) == 2


def test_a_shutter_that_may_not_move_while_disarmed(
    make_boat: Callable[..., Boat], fitted: Callable[..., VesselConfig]
) -> None:
    boat = make_boat(fitted(BELOW, while_disarmed=False))
    for action in (TakePicture(), ByTime(0, 1.0), ByDistance(0, 2.0, True)):
        outcome = boat.supervisor.payload.request(action, boat.now_s)
        assert outcome.result is Result.TEMPORARILY_REJECTED and "moves only while the boat is armed" in outcome.reason
    boat.supervisor.arm(boat.now_s)
    boat.step()
    assert boat.supervisor.payload.request(ByTime(0, 1.0), boat.now_s).accepted
    boat.step(2.0)
    taken = len(boat.shots)
    boat.supervisor.payload.request(TakePicture(), boat.now_s)
    boat.supervisor.disarm(boat.now_s)
    boat.step(5.0)
    boat.supervisor.arm(boat.now_s)
    boat.step(5.0)
    assert taken == 2 and len(boat.shots) == taken


def test_an_operator_is_told_what_begins_and_ends(boat: Boat) -> None:
    for action in (ByDistance(1, 5.0), StopPictures(), ByTime(2, 0.1), TriggerControl(False, None)):
        assert boat.supervisor.payload.request(action, boat.now_s).accepted
        boat.step()
    assert [text for name, text in boat.said if name == "camera"] == [
        "Camera below: a picture every 5 m",
        "Cameras: no more pictures",
        "Camera ahead: a picture every 1 s",
    ]


def test_a_survey_takes_its_pictures_and_tells_at_upload_and_at_its_end(boat: Boat) -> None:
    boat.upload((2.0, 0.0), (22.0, 0.0), (24.0, 0.0), commands={1: do(206, 5.0, 0, 1, 1), 3: do(206, 0, 0, 1, 1)})
    boat.step()
    assert ("survey", "Survey: 1 transect, every 5 m, about 6 pictures") in boat.said
    begin(boat)
    boat.until(lambda: boat.status.mission.reached == 3)
    boat.step()
    north_m = [boat.frame.to_ned(shot.lat_deg, shot.lon_deg)[0] for shot in boat.shots]
    steps = [b - a for a, b in itertools.pairwise(north_m)]
    assert {shot.name for shot in boat.shots} == {"below"}
    assert steps[:3] == pytest.approx([5.0] * 3, abs=0.1) and 5 <= len(north_m) <= 6
    assert f"Mission took {len(north_m)} pictures" in boat.texts()
    assert not {"payload_missing", "payload_refused", "camera"} & set(boat.names())


def test_a_mission_that_is_paused_takes_no_pictures(boat: Boat) -> None:
    boat.upload((2.0, 0.0), (80.0, 0.0), commands={1: do(206, 2.0, 0, 0, 1)})
    begin(boat)
    boat.until(lambda: len(boat.shots) == 3)
    boat.supervisor.pause(boat.now_s)
    boat.step(20.0)
    assert len(boat.shots) <= 4
    taken = len(boat.shots)
    boat.supervisor.resume(boat.now_s)
    boat.until(lambda: len(boat.shots) == taken + 3)


def test_a_mission_that_jumps_into_a_transect_takes_pictures_there(boat: Boat) -> None:
    boat.upload((2.0, 0.0), (30.0, 0.0), (60.0, 0.0), commands={1: do(206, 5.0, 0, 0, 1)})
    boat.supervisor.set_current(3, False, boat.now_s)
    begin(boat)
    boat.until(lambda: len(boat.shots) == 2)


def test_another_plan_ends_the_pictures_of_the_old(boat: Boat) -> None:
    boat.upload((2.0, 0.0), (80.0, 0.0), commands={1: do(206, 2.0, 0, 0, 1)})
    begin(boat)
    boat.until(lambda: len(boat.shots) == 2)
    boat.upload((5.0, 5.0), (60.0, 60.0))
    boat.step(20.0)
    assert len(boat.shots) == 2


def test_what_a_mission_has_switched_off_is_on_for_the_next_one(boat: Boat) -> None:
    boat.upload((2.0, 0.0), (80.0, 0.0), commands={1: do(206, 2.0, 0, 0, 1), 2: do(2003, 0.0, 0.0, 1.0)})
    begin(boat)
    boat.step(30.0)
    assert boat.status.mission.reached == 1 and boat.shots == []
    boat.upload((20.0, 5.0), (60.0, 60.0), commands={1: do(206, 2.0, 0, 0, 1)})
    boat.until(lambda: len(boat.shots) == 2)


def test_what_an_operator_has_switched_off_stays_off(boat: Boat) -> None:
    boat.upload((2.0, 0.0), (80.0, 0.0), commands={1: do(206, 2.0, 0, 0, 1)})
    assert boat.supervisor.payload.request(TriggerControl(False, None), boat.now_s).accepted
    begin(boat)
    boat.step(30.0)
    assert boat.status.mission.reached == 1 and boat.shots == []


@pytest.mark.parametrize("armed", [False, True])
def test_a_boat_without_a_camera_says_so_and_sails_on(make_boat: Callable[..., Boat], armed: bool) -> None:
    boat = make_boat()
    boat.upload((2.0, 0.0), (8.0, 0.0), (10.0, 0.0), commands={1: do(206, 2.0, 0, 1), 3: do(206, 0, 0, 1)})
    boat.step()
    text = "No camera for DO_SET_CAM_TRIGG_DIST, item 2 and 1 more"
    assert text in boat.texts() and boat.severities["payload_missing"] is Severity.WARNING
    if armed:
        begin(boat)
        boat.until(lambda: boat.status.mission.reached == 3)
        assert boat.names().count("payload_refused") == 1 and boat.shots == []
    outcome = boat.supervisor.payload.request(TakePicture(), boat.now_s)
    assert outcome.result is Result.DENIED and outcome.reason == "No camera: add [[camera]] to the vessel file"


def test_commands_of_a_mission_for_a_gimbal(boat: Boat) -> None:
    boat.upload((3.0, 0.0), (9.0, 0.0), commands={1: do(205, -90.0), 2: do(531, 0, 2.0)})
    boat.step()
    assert "Item 2 DO_MOUNT_CONTROL: no gimbal on a link" in boat.texts()
    assert "Item 3 SET_CAMERA_ZOOM: no camera on a link" in boat.texts()
    boat.supervisor.payload.hear((), (154,))
    begin(boat)
    boat.until(lambda: boat.status.mission.reached == 2)
    assert boat.forwards == [Forward(PayloadPart.GIMBAL, 205, (-90.0, 0, 0, 0, 0, 0, 0), None, 0, 1)]
    assert [text for name, text in boat.said if name == "payload_refused"] == [
        "Item 3 SET_CAMERA_ZOOM: no camera on a link"
    ]


def test_a_camera_on_a_link_takes_pictures_once_it_is_heard(
    make_boat: Callable[..., Boat], fitted: Callable[..., VesselConfig]
) -> None:
    boat = make_boat(fitted(LINKED))
    boat.upload((3.0, 0.0), (9.0, 0.0), commands={1: do(206, 2.0, 0, 1)})
    boat.step()
    assert "Camera linked (component 100) is not heard" in boat.texts()
    payload = boat.supervisor.payload
    assert payload.request(TakePicture(), boat.now_s).result is Result.TEMPORARILY_REJECTED
    payload.hear((100, 101), (154, 171))
    assert payload.request(TakePicture(), boat.now_s).accepted
    boat.step()
    assert [(shot.component, shot.number) for shot in boat.shots] == [(100, 1)]
    assert payload.component(PayloadPart.CAMERA, 0) == 100 and payload.component(PayloadPart.GIMBAL, 171) == 171
    assert payload.component(PayloadPart.GIMBAL, 0) == 154 and payload.component(PayloadPart.GIMBAL, 172) is None


def test_a_shutter_on_a_wire_is_in_the_mode_for_pictures(boat: Boat) -> None:
    """QGroundControl's surveys begin with SET_CAMERA_MODE."""
    pictures, video = (Forward(PayloadPart.CAMERA, 530, (0.0, mode, 0, 0, 0, 0, 0), None, 0, 1) for mode in (0.0, 1.0))
    assert boat.supervisor.payload.request(pictures, boat.now_s, by_mission=True).accepted
    assert not boat.supervisor.payload.request(video, boat.now_s, by_mission=True).accepted
    assert boat.forwards == []


def test_a_camera_that_is_too_slow_is_told_once(boat: Boat) -> None:
    boat.upload((2.0, 0.0), (60.0, 0.0), commands={1: do(206, 0.1, 0, 0, 2)})
    begin(boat)
    boat.until(lambda: len(boat.shots) > 5)
    assert boat.names().count("pictures_left_out") == 1
    assert "Camera ahead is too slow: pictures left out" in boat.texts()
