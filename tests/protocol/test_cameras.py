"""A camera that is MAVSDK's camera server, on a link of the running process: the boat measures and triggers, the camera
takes the pictures."""

from __future__ import annotations

import csv
import json
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk, System
from mavsdk.plugins.camera_server import CameraFeedback, CameraServer, CaptureInfo, Information
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.plugins.telemetry import Telemetry

from tests.protocol.process import Companion
from tests.waiting import CAP_S, wait_until

pytestmark = pytest.mark.process

CAMERA = """
[[camera]]
name = "mast"
kind = "mavlink"
component = 100
interval_s = 0.2
"""


def vessel(folder: Path) -> str:
    text = resources.files("companion.vessels").joinpath("revolt.toml").read_text(encoding="utf-8")
    file = folder / "revolt_with_camera.toml"
    file.write_text(text + CAMERA, encoding="utf-8")
    return str(file)


class Ground:
    """A ground station by MAVSDK that sends commands as they are; `acks` are the results of each."""

    def __init__(self, system: System) -> None:
        self._direct = MavlinkDirect(system)
        self.acks: dict[int, int] = {}
        self.texts: list[str] = []
        self._direct.subscribe_message("COMMAND_ACK", self._take)
        Telemetry(system).subscribe_status_text(lambda text, _: self.texts.append(text.text))

    def _take(self, message: MavlinkMessage, _user: Any) -> None:
        fields = json.loads(message.fields_json)
        self.acks[fields["command"]] = fields["result"]

    def result(self, command: int, *params: float) -> int:
        self.acks.pop(command, None)
        fields = {"target_system": 1, "target_component": 1, "command": command, "confirmation": 0}
        fields |= {f"param{n}": params[n - 1] if n <= len(params) else 0.0 for n in range(1, 8)}
        self._direct.send_message(MavlinkMessage("COMMAND_LONG", 0, 0, 1, 1, json.dumps(fields)))
        wait_until(lambda: command in self.acks, f"the answer to {command}")
        return self.acks[command]


def test_mavsdks_camera_takes_the_boats_pictures(tmp_path: Path) -> None:
    ground_station = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
    mast = Configuration.create_manual(1, 100, True)
    with Companion(tmp_path, speed=5.0, vessel=vessel(tmp_path)) as companion:
        with Mavsdk(ground_station) as ground_sdk, Mavsdk(mast) as camera_sdk:
            ground_sdk.add_any_connection(f"udpin://127.0.0.1:{companion.udp_port}")
            system = ground_sdk.first_autopilot(CAP_S)
            assert system is not None
            ground = Ground(system)
            assert ground.result(2000, 0.0, 0.0, 1.0, 1.0) == 1
            wait_until(lambda: "Camera mast (component 100) is not heard" in ground.texts, "the reason")

            camera_sdk.add_any_connection(f"tcpout://127.0.0.1:{companion.tcp_port}")
            server = CameraServer(camera_sdk.server_component_by_type(ComponentType.CAMERA))
            server.set_information(Information(vendor_name="test", model_name="mast", firmware_version="1.0.0"))
            asked: list[int] = []

            def take(index: int, _user: Any) -> None:
                asked.append(index)
                server.respond_take_photo(CameraFeedback.OK, CaptureInfo(is_success=True, index=len(asked)))

            server.subscribe_take_photo(take)
            wait_until(lambda: ground.result(2000, 0.0, 0.0, 1.0, 2.0) == 0, "the camera is heard")
            wait_until(lambda: len(asked) == 1, "the picture")
            assert ground.result(214, 1000.0) == 0
            wait_until(lambda: len(asked) >= 4, "pictures by time")
            assert ground.result(2001) == 0
            assert ground.result(1000, -45.0) == 1  # no gimbal
        log = companion.log_folder
    with (log / "geotags.csv").open(encoding="utf-8") as rows:
        tags = list(csv.DictReader(rows))
    assert {tag["camera"] for tag in tags} == {"mast"} and len(tags) >= 4
