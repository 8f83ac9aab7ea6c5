"""A camera on a relay or a servo of an emulated board: it takes a picture at each pulse, and notes where it really
is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

from companion.config.devices import ActuatorConfig
from companion.config.payload import CameraConfig
from companion.core.frames import body_to_ned
from companion.core.tick import Tick
from sitl.hull import Hull

COLUMNS = ("t_s", "camera", "north_m", "east_m", "yaw_rad")


@dataclass(frozen=True, slots=True)
class Picture:
    """One picture: when, by which camera, and where its lens was from home."""

    t_s: float
    camera: str
    north_m: float
    east_m: float
    yaw_rad: float


class EmulatedCamera:
    """`look(t_s)` each step of the plant; `pictures` are those taken so far."""

    def __init__(self, config: CameraConfig, bridge: ActuatorConfig, board: Any, hull: Hull) -> None:
        """`board`: the emulated board of `bridge`, which drives the camera's relay or servo."""
        self._config, self._board, self._hull = config, board, hull
        by_relay = config.relay is not None
        self._number = bridge.relays.index(config.relay) if by_relay else bridge.servos.index(config.servo or "")
        self._pressed = False
        self.pictures: list[Picture] = []

    def look(self, t_s: float) -> None:
        """Take a picture if the shutter has just been pressed."""
        before, self._pressed = self._pressed, self._is_pressed()
        if self._pressed and not before:
            hull = self._hull
            north_m, east_m = body_to_ned(self._config.x_m, self._config.y_m, hull.yaw_rad)
            self.pictures.append(
                Picture(t_s, self._config.name, hull.north_m + north_m, hull.east_m + east_m, hull.yaw_rad)
            )

    def _is_pressed(self) -> bool:
        if self._config.relay is not None:
            return bool(self._board.relay(self._number))
        return bool(self._board.servo_us(self._number) == self._config.press_us)


def emulated_cameras(
    cameras: Sequence[CameraConfig], bridges: Sequence[ActuatorConfig], boards: Sequence[Any], hull: Hull
) -> list[EmulatedCamera]:
    """The cameras that hang on a board's output; a MAVLink camera has no wire."""
    found = []
    for camera in cameras:
        for bridge, board in zip(bridges, boards, strict=True):
            if camera.relay in bridge.relays or camera.servo in bridge.servos:
                found.append(EmulatedCamera(camera, bridge, board, hull))
    return found


class PictureLog:
    """Recorder that writes pictures.csv: where each picture was really taken."""

    def __init__(self, folder: Path, cameras: Sequence[EmulatedCamera]) -> None:
        self._cameras = cameras
        self._written = [0] * len(cameras)
        folder.mkdir(parents=True, exist_ok=True)
        self._file: TextIO = (folder / "pictures.csv").open("w", encoding="utf-8", buffering=1)
        self._file.write(",".join(COLUMNS) + "\n")

    def record(self, tick: Tick) -> None:
        """Write the new pictures; the tick itself is not used."""
        self.write()

    def write(self) -> None:
        """Write the pictures since the last call."""
        for i, camera in enumerate(self._cameras):
            for p in camera.pictures[self._written[i] :]:
                self._file.write(f"{p.t_s:.3f},{p.camera},{p.north_m:.5f},{p.east_m:.5f},{p.yaw_rad:.6f}\n")
            self._written[i] = len(camera.pictures)

    def close(self) -> None:
        """Close the file."""
        self._file.close()
