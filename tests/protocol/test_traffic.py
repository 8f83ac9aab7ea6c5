"""Traffic as a ground station meets it: vessels that another system sees come back to all, are warned of, and a changed
course shows."""

from __future__ import annotations

from pathlib import Path

from companion.io.mavlink.wire import messages as mavlink
from tests.protocol.desk import Desk, of
from tests.protocol.test_found_faults import desk_in, sail
from tests.protocol.test_qgroundcontrol import ARM, MISSION, item

KNOWN = (
    mavlink.AIS_FLAGS_VALID_COG
    | mavlink.AIS_FLAGS_VALID_VELOCITY
    | mavlink.AIS_FLAGS_VALID_DIMENSIONS
    | mavlink.AIS_FLAGS_VALID_NAME
)


def seen(desk: Desk, north_m: float, east_m: float, course_deg: float, speed_mps: float) -> None:
    lat_deg, lon_deg = desk.vessel.frame.to_geodetic(north_m, east_m)
    message = mavlink.MAVLink_ais_vessel_message(
        230_000_001,
        round(lat_deg * 1e7),
        round(lon_deg * 1e7),
        round(course_deg * 100),
        0xFFFF,
        round(speed_mps * 100),
        0,
        0,
        37,
        4,
        4,
        2,
        2,
        b"",
        b"NORA",
        0,
        KNOWN,
    )
    desk.tell(message)


def test_seen_by_another_shown_to_all_and_kept_clear_of(tmp_path: Path) -> None:
    desk = desk_in(tmp_path)
    desk.vessel.parameters.set("CA_ACTION", 3.0)
    desk.upload([item(0, 16, 150.0, 0.0)])
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))
    desk.result(ARM, 1.0)
    begin_s = desk.rig.now_s
    for n in range(12):
        seen(desk, 90.0 - 0.6 * (desk.rig.now_s - begin_s), 0.0, 180.0, 0.6)
        sail(desk, 2.0)
        if n == 1:
            assert desk.latest("AIS_VESSEL").MMSI == 230_000_001 and desk.latest("AIS_VESSEL").name == "NORA"
    assert any(text.startswith("Traffic: NORA head-on") for text in desk.texts())
    assert "Traffic: course to starboard for NORA" in desk.texts()
    target = desk.latest("POSITION_TARGET_GLOBAL_INT")
    _, east_m = desk.vessel.frame.to_ned(target.lat_int * 1e-7, target.lon_int * 1e-7)
    assert east_m > 1.0, "the changed route is the position target"
    assert len(of(desk.received, "AIS_VESSEL")) <= desk.rig.now_s - begin_s + 2.0, "none more than once a second"
    desk.close()


def test_nonsense_is_not_taken(tmp_path: Path) -> None:
    desk = desk_in(tmp_path)
    for mmsi, lat, lon in ((0, 0, 0), (2**32 - 1, 0, 0), (5, 2**31 - 1, 2**31 - 1)):
        fields = (
            mmsi,
            lat,
            lon,
            65535,
            65535,
            65535,
            -128,
            255,
            255,
            65535,
            65535,
            255,
            255,
            b"\xff" * 7,
            b"\x01" * 20,
            65535,
            65535,
        )
        desk.tell(mavlink.MAVLink_ais_vessel_message(*fields))
    sail(desk, 2.0)
    assert of(desk.received, "AIS_VESSEL") == [] and not any("not handled" in text for text in desk.texts())
    desk.close()
