"""What QGroundControl asks while it connects and while its pages are opened one after the other: nothing is missing,
nothing is refused. The list of parameters is `data/qgroundcontrol_parameters.toml`."""

from __future__ import annotations

import re
import struct
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.io.mavlink.transfer.component_metadata import parameter_row
from companion.io.mavlink.wire import messages as mavlink
from companion.params.spec import ParamType
from companion.params.table import TABLE
from tests.protocol.desk import Desk, of

ASKED = tomllib.loads((Path(__file__).parent / "data" / "qgroundcontrol_parameters.toml").read_text(encoding="utf-8"))
PAGES = ASKED["page"]
SPECS = {spec.name: spec for spec in TABLE}
FINER = {"COM_DL_LOSS_T"}  # seconds with a fraction here, whole ones in PX4
INT32, REAL32 = mavlink.MAV_PARAM_TYPE_INT32, mavlink.MAV_PARAM_TYPE_REAL32
REQUEST, CALIBRATE, CAMERA = 512, 241, 521


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    desk = Desk(tmp_path)
    desk.tick()
    desk.heartbeat()
    yield desk
    desk.close()


def write(desk: Desk, name: str, value: float) -> float:
    """PARAM_SET as QGroundControl sends it; the value of the echo, which it waits for 1 s."""
    whole = SPECS[name].type is ParamType.INT32
    packed = struct.unpack("<f", struct.pack("<i", int(value)))[0] if whole else float(value)
    kind = INT32 if whole else REAL32
    answers = desk.tell(mavlink.MAVLink_param_set_message(1, 1, name.encode(), packed, kind))
    echo = next(m for m in of(answers, "PARAM_VALUE") if m.param_id == name)
    assert echo.param_type == kind
    return read_value(echo)


def read_value(message: Any) -> float:
    if message.param_type == INT32:
        return float(struct.unpack("<i", struct.pack("<f", message.param_value))[0])
    return float(message.param_value)


def type_of(name: str) -> str:
    """PX4's."""
    kinds = [kind for kind, names in ASKED["types"].items() if any(re.fullmatch(pattern, name) for pattern in names)]
    assert len(kinds) == 1, name
    return str(kinds[0])


# --- the table -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page["name"])
def test_no_name_that_a_page_asks_for_is_missing(page: dict[str, Any]) -> None:
    assert not [name for name in page["asks"] if name not in SPECS]
    served = [name for name in (*page["asks"], *page.get("if_exists", ())) if name in SPECS]
    assert not [name for name in served if name not in FINER and SPECS[name].type.name != type_of(name)]


def test_what_would_switch_something_on_that_is_not_there_is_not_served() -> None:
    """HITL, PX4's logs, its crazyflie radio, ArduPilot's names for reversed channels, buttons for modes."""
    off = {
        "SYS_HITL",
        "SYS_LOGGER",
        "SLNK_RADIO_CHAN",
        "RC1_REVERSED",
        "RC_MAP_FLTM_BTN",
        "SYS_VEHICLE_RESP",
    }
    assert not off & set(SPECS)
    assert off <= {name for page in PAGES for name in page.get("if_exists", ())}


def test_every_read_only_name_is_there_because_a_page_asks_for_it() -> None:
    asked = {name for page in PAGES for name in (*page["asks"], *page.get("if_exists", ()))}
    others = {"FRAME_CLASS", "ARMING_SKIPCHK"}  # ArduPilot's ground stations
    assert {spec.name for spec in TABLE if spec.read_only} <= asked | others


def test_lists_have_names_for_their_values() -> None:
    """What the pages show as a list to choose from; the channels of the sticks are set by calibration."""
    for name, spec in SPECS.items():
        if re.fullmatch(r"COM_FLTMODE.|RC_MAP_.*|SENS_BOARD_ROT|CAL_MAG._ROT|BAT1_SOURCE|GF_ACTION|.*_ACT", name):
            row = parameter_row(spec, spec.default)
            assert spec.default in {value["value"] for value in row["values"]}, name
            assert all(value["description"] for value in row["values"]), name


def test_sliders_have_ends(desk: Desk) -> None:
    """A slider without a range builds a mark for each integer, and QGroundControl hangs."""
    for name in ("GF_MAX_HOR_DIST", "GF_MAX_VER_DIST", "CP_DIST", "RTL_RETURN_ALT", "COM_DISARM_LAND", "BAT_LOW_THR"):
        row = parameter_row(SPECS[name], SPECS[name].default)
        assert row["min"] <= row["default"] <= row["max"] and (row["max"] - row["min"]) / 500.0 <= 20.0


# --- the replay ----------------------------------------------------------------------------------------------------


def connect(desk: Desk) -> dict[str, float]:
    """Section 3 of the reference, message by message; the values of all parameters."""
    assert of(desk.command(REQUEST, 148.0), "AUTOPILOT_VERSION")
    index = 0
    while True:
        index += 1
        mode = of(desk.command(REQUEST, 435.0, float(index)), "AVAILABLE_MODES")[0]
        if mode.mode_index >= mode.number_modes:
            break
    assert of(desk.command(REQUEST, 397.0), "COMPONENT_METADATA")
    values = of(desk.tell(mavlink.MAVLink_param_request_list_message(1, 0)), "PARAM_VALUE")
    while len(values) < 1 + len(TABLE):  # the hash, and the list
        values += of(desk.tick(), "PARAM_VALUE")
    for kind in (0, 1, 2):
        assert of(desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, kind)), "MISSION_COUNT")
    desk.tell(mavlink.MAVLink_system_time_message(1_900_000_000_000_000, 1000))
    return {message.param_id: read_value(message) for message in values}


def open_page(desk: Desk, page: dict[str, Any], known: dict[str, float]) -> None:
    """Its lookups, which QGroundControl answers from the list; what it has not got it reads from the boat."""
    for name in page["asks"]:
        assert name in known, f"{page['name']}: {name} is missing"
        answers = desk.tell(mavlink.MAVLink_param_request_read_message(1, 1, name.encode(), -1))
        assert [read_value(m) for m in of(answers, "PARAM_VALUE")] == [known[name]], name
        assert not of(answers, "PARAM_ERROR")
    for name in page.get("if_exists", ()):
        answers = desk.tell(mavlink.MAVLink_param_request_read_message(1, 1, name.encode()[:16], -1))
        assert len(of(answers, "PARAM_VALUE")) == (name in known)


def test_connection_and_every_page(desk: Desk) -> None:
    """No parameter is missing, no read refused, and nothing is said but what concerns the operator."""
    known = connect(desk)
    assert set(known) == {*SPECS, "_HASH_CHECK"}
    for page in PAGES:
        open_page(desk, page, known)
    desk.tick(20)
    texts = [text.lower() for text in desk.texts()]
    assert not [text for text in texts if "unknown parameter" in text or "read-only" in text]
    for probe in (280.0, 259.0):
        assert desk.result(REQUEST, probe) == mavlink.MAV_RESULT_UNSUPPORTED
    assert desk.result(CAMERA) == mavlink.MAV_RESULT_UNSUPPORTED


def test_messages_that_pages_ask_for(desk: Desk) -> None:
    """What the pages show lives on streams; each can be had at once, and at another rate, as the inspector asks."""
    connect(desk)
    desk.ready()
    desk.rig.world.set_transmitter((1500,) * 8)
    desk.tick(20)
    for kind in ("RC_CHANNELS", "BATTERY_STATUS", "SYS_STATUS", "HOME_POSITION", "ATTITUDE", "GPS_RAW_INT"):
        number = getattr(mavlink, f"MAVLINK_MSG_ID_{kind}")
        answer = desk.command(REQUEST, float(number))
        assert of(answer, "COMMAND_ACK")[0].result == mavlink.MAV_RESULT_ACCEPTED and of(answer, kind), kind
        assert desk.result(511, float(number), 100_000.0) == mavlink.MAV_RESULT_ACCEPTED
    assert desk.latest("RC_CHANNELS").chancount == 8


def test_what_a_person_sets_on_the_pages_is_taken(desk: Desk) -> None:
    """One value of each page, as its control writes it."""
    known = connect(desk)
    written = {
        "GF_MAX_HOR_DIST": 100.0, "GF_ACTION": 3, "COM_LOW_BAT_ACT": 1, "BAT_LOW_THR": 0.3, "NAV_DLL_ACT": 2, "COM_RC_LOSS_T": 1.0,
        "RC_MAP_FLTMODE": 6, "COM_FLTMODE1": 8, "RC_MAP_KILL_SW": 7, "RC_MAP_ROLL": 4, "RC4_REV": -1, "RC1_TRIM": 1512,
        "SENS_BOARD_ROT": 4, "CAL_MAG0_ROT": 6, "BAT1_SOURCE": 1, "BAT1_N_CELLS": 3,
    }  # fmt: skip
    for name, value in written.items():
        assert write(desk, name, value) == pytest.approx(value) != known[name]
    answers = desk.tell(mavlink.MAVLink_param_set_message(1, 1, b"SENS_DPRES_OFF", 5.0, REAL32))
    assert of(answers, "PARAM_ERROR") and read_value(of(answers, "PARAM_VALUE")[-1]) == 0.0
    desk.tick()
    assert "SENS_DPRES_OFF stays 0: it is read-only" in desk.texts()


def test_the_fence_panel_draws_the_circle_that_the_boat_keeps(desk: Desk) -> None:
    """It draws a circle of GF_MAX_HOR_DIST around HOME_POSITION; 0, the default, draws none."""
    known = connect(desk)
    assert known["GF_MAX_HOR_DIST"] == 0.0
    desk.ready()
    desk.tick(20)
    home = desk.latest("HOME_POSITION")
    assert desk.latest("FENCE_STATUS") is None
    assert write(desk, "GF_MAX_HOR_DIST", 60.0) == 60.0
    desk.tick(20)
    assert desk.latest("FENCE_STATUS").breach_status == 0
    areas = desk.vessel.supervisor.parts.fence.areas()
    assert areas is not None
    north_m, east_m = desk.vessel.frame.to_ned(home.latitude * 1e-7, home.longitude * 1e-7)
    for off_m, inside in ((59.9, True), (60.1, False)):
        assert areas.fence.contains(north_m + off_m, east_m) is inside
