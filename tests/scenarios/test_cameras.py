"""Pictures of a sailing boat, by the pulses that the emulated camera counts and by the truth."""

from __future__ import annotations

import csv
import itertools
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from companion.cli.rig import LockstepRig
from companion.io.mavlink.wire import messages as mavlink
from companion.mission.plan import PlanItem, PlanKind
from sitl.scenarios import SCENARIOS
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import run
from tests.protocol.desk import Desk, of
from tests.scenarios.seeds import seeds
from tests.scenarios.test_mission_files import message

CAMERAS = """
[[servo]]
name = "finger"
rest_us = 1100.0
while_disarmed = true

[[relay]]
name = "shutter"
while_disarmed = true

[[camera]]
name = "ahead"
kind = "servo"
servo = "finger"
press_us = 1900.0

[[camera]]
name = "below"
kind = "relay"
relay = "shutter"
interval_s = 0.5
"""


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    text = resources.files("companion.vessels").joinpath("revolt.toml").read_text(encoding="utf-8")
    driven = 'thrusters = ["stern_port", "stern_starboard", "bow"]'
    file = tmp_path / "revolt_with_cameras.toml"
    fitted = text.replace(driven, f'{driven}\nservos = ["finger"]\nrelays = ["shutter"]', 1)
    file.write_text(fitted + CAMERAS, encoding="utf-8")
    made = Desk(tmp_path, LockstepRig(Conditions(str(file), seed=3), tmp_path / "log"))
    made.tick()
    made.ready()
    return made


def pictures(desk: Desk) -> dict[str, list[Any]]:
    """Those that the emulated cameras have taken, by name."""
    found: dict[str, list[Any]] = {}
    for camera in desk.rig.world.cameras:
        for picture in camera.pictures:
            found.setdefault(picture.camera, []).append(picture)
    return found


def test_a_command_becomes_a_pulse_a_message_and_a_geotag(desk: Desk, tmp_path: Path) -> None:
    assert desk.result(2000, 0.0, 0.0, 1.0, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    desk.received.clear()
    desk.tick(5)
    taken = pictures(desk)
    assert {name: len(shots) for name, shots in taken.items()} == {"ahead": 1, "below": 1}
    assert len(of(desk.received, "CAMERA_FEEDBACK")) == 2
    desk.close()
    for name in ("geotags.csv", "pictures.csv"):
        with (tmp_path / "log" / name).open(encoding="utf-8") as rows:
            assert [row["camera"] for row in csv.DictReader(rows)] == ["ahead", "below"]


def test_pictures_by_time_of_one_camera(desk: Desk) -> None:
    assert desk.result(2000, 2.0, 0.5, 6.0) == mavlink.MAV_RESULT_ACCEPTED
    desk.tick(60)
    (shots,) = pictures(desk).values()
    assert len(shots) == 6 and shots[0].camera == "below"
    steps = [b.t_s - a.t_s for a, b in itertools.pairwise(shots)]
    assert steps == pytest.approx([0.5] * 5, abs=0.06)
    desk.close()


def test_a_survey_is_told_at_upload(desk: Desk) -> None:
    home = desk.vessel.config.home
    item = PlanItem(0, 16, 3, 0.0, 0.0, 0.0, 0.0, round(home.lat_deg * 1e7), round(home.lon_deg * 1e7), 0.0)
    items = [item, PlanItem(1, 206, 2, 5.0, 0.0, 1.0, 0.0, 0, 0, 0.0)]
    items += [PlanItem(2, 16, 3, 0.0, 0.0, 0.0, 0.0, item.x + 2000, item.y, 0.0)]
    items += [PlanItem(3, 205, 2, -90.0, 0.0, 0.0, 0.0, 0, 0, 2.0)]
    assert desk.upload([message(one, PlanKind.MISSION) for one in items]) == 0
    desk.tick(2)
    assert "Survey: 1 transect, every 5 m, about 5 pictures" in desk.texts()
    assert "Item 4 DO_MOUNT_CONTROL: no gimbal on a link" in desk.texts()
    desk.close()


@pytest.mark.parametrize("seed", seeds(1, 3))
def test_a_transect_by_the_truth(tmp_path: Path, seed: int) -> None:
    settings = {"transects": "1", "length": "6", "spacing": "1"}
    outcome = run(SCENARIOS["pictures"], LockstepRig, tmp_path, seed=seed, changes=settings)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    assert outcome.metrics["spacing_worst_m"] < 0.1 and outcome.metrics["geotag_worst_m"] < 0.1
