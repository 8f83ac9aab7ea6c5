"""Where fuzzing begins: a few good inputs of each target, so that a fuzzer need not find the format itself."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping
from importlib import resources
from pathlib import Path

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import pack
from companion.mission import files
from tests.fuzz.targets import GOOD
from tests.unit.io.sensors.test_mtdata2 import FORCE, RATE
from tests.unit.io.sensors.test_nmea0183 import GGA, HDT, VTG
from tests.unit.io.sensors.test_sbus import CENTRED

_FILES = Path(__file__).parents[2] / "mission_files"
_FTP = struct.Struct("<HBBBBBBI")


def _piece(data: bytes) -> bytes:
    return bytes([min(len(data), 63)]) + data[:63]


def _framer() -> Iterator[bytes]:
    yield b"\0" + _piece(GOOD[:9]) + _piece(GOOD[9:] + GOOD)
    yield b"\0" + _piece(b"\xfe\x09\x00\x01\x01\x00" + bytes(11)) + _piece(b"\xfd" * 30)
    yield b"\1" + b"".join(_piece(bytes([0, number]) + bytes(range(1, 40))) for number in range(0, 240, 16))


def _mission() -> Iterator[bytes]:
    """An upload of two items, a download, a clear, by the places of `_MISSION_IDS`."""
    count = pack(mavlink.MAVLink_mission_count_message(1, 1, 2, 0)).payload
    items = [
        pack(mavlink.MAVLink_mission_item_int_message(1, 1, seq, 3, 16, 0, 1, 0, 0, 0, 0, 634400000, 103990000, 0, 0))
        for seq in range(2)
    ]
    upload = _piece(b"\0" + count)
    for item in items:
        upload += _piece(b"\x27" + item.payload)  # place 0 of the peers, MISSION_ITEM_INT
    yield upload + _piece(b"\x06" + b"\1\1") + _piece(b"\x15" + b"\0\0\1\1") + _piece(b"\xf2")
    yield _piece(b"\0" + count) + _piece(b"\xff") * 5 + _piece(b"\1" + b"\0\0\1\0\1\1")
    yield upload * 2 + _piece(b"\x2d" + b"\1\1\xff") + _piece(b"\xf9")


def _ftp() -> Iterator[bytes]:
    def asked(opcode: int, data: bytes = b"", session: int = 0, offset: int = 0, size: int | None = None) -> bytes:
        size = len(data) if size is None else size
        return _piece(b"\0" + _FTP.pack(1, session, opcode, size, 0, 0, 0, offset) + data)

    yield asked(3, b"/") + asked(4, b"general.json") + asked(15, offset=10, size=100) + _piece(b"\xf1") + asked(1)
    yield asked(14, b"parameters.json.xz") + asked(4, b"@PARAM/param.pck") + asked(5, size=239) + asked(2)
    yield asked(4, b"@MISSION/mission.dat", 3) + asked(5, b"", 3, 0xFFFFFFFF, 255) + asked(200) + asked(7, b"x")


def _nmea() -> Iterator[bytes]:
    whole = GGA + HDT + VTG
    yield b"\0" + b"".join(_piece(whole[at : at + 50]) for at in range(0, len(whole), 50))
    yield b"\1" + b"\n".join(line[1:].partition(b"*")[0] for line in whole.splitlines() if line)
    more = (
        b"GPRMC,120000.00,A,6326.3340,N,01023.9400,E,1.0,84.4,010626,,,A",
        b"WIMWV,214.8,R,10.5,M,A",
        b"SDDBT,,,4.2,M,,",
    )
    yield b"\1" + b"\n".join((*more, b"GPZDA,120000.00,01,06,2026,00,00", b"HCHDG,98.3,0.0,E,12.6,W", b"TIROT,2.5,A"))


def _mtdata2() -> Iterator[bytes]:
    counter = struct.pack(">HBH", 0x1020, 2, 7) + struct.pack(">HBI", 0x1060, 4, 10_000)
    yield b"\1" + _piece(counter + FORCE + RATE)
    euler, field = struct.pack(">HB3f", 0x2030, 12, 1.0, 2.0, 3.0), struct.pack(">HB3f", 0xC020, 12, 0.1, 0.2, 0.3)
    place = struct.pack(">HB2d", 0x5043, 16, 63.4, 10.4) + struct.pack(">HB3d", 0xD013, 24, 0.1, 0.2, 0.3)
    yield b"\1" + _piece(counter + euler + field) + _piece(counter + place)
    yield b"\0" + _piece(bytes.fromhex("faff36051020020001")) + _piece(b"\xfa\xff\x36\xff\x00\x10")


def _sbus() -> Iterator[bytes]:
    yield b"\1" + _piece(CENTRED[1:24]) * 12
    yield b"\1" + _piece(CENTRED[1:24]) * 12 + _piece(CENTRED[1:23] + b"\x0c") * 4
    yield b"\0" + _piece(CENTRED) * 12 + _piece(CENTRED[:9]) + _piece(CENTRED)


def _crsf() -> Iterator[bytes]:
    channels, link = b"\x16" + CENTRED[1:23], bytes((0x14, 50, 50, 100, 8, 0, 4, 3, 50, 100, 8))
    yield b"\1" + (_piece(link) + _piece(channels)) * 4
    yield b"\1" + _piece(channels) * 4 + _piece(bytes((0x14, 50, 50, 0, 8, 0, 4, 3, 50, 0, 8))) + _piece(channels)
    yield b"\0" + _piece(bytes.fromhex("c81816") + CENTRED[1:23]) + _piece(b"\xc8\x04\x28\x00\xea\x54")


def _plans() -> Iterator[bytes]:
    suffixes = tuple(files.FORMATS)
    for number, suffix in enumerate(suffixes):
        source = _FILES / ("trondheim_tour.waypoints" if suffix == ".waypoints" else "trondheim_square.plan")
        plan = files.read(source.name, source.read_text(encoding="utf-8"))
        try:
            yield bytes([number]) + files.write(f"plan{suffix}", plan).encode()
        except files.PlanFileError:
            continue
    yield b"\0" + (_FILES / "river_corridor.plan").read_bytes()
    yield (
        bytes([suffixes.index(".gpx")])
        + b'<gpx><rte><rtept lat="63.4" lon="10.4"/><rtept lat="63.5" lon="10.4"/></rte></gpx>'
    )
    yield bytes([suffixes.index(".json")]) + b'[{"lat": 63.4, "lon": 10.4}, {"lat": 63.5, "lon": 10.4}]'


_PARTS = (
    b"",
    b"name = 1",
    b'name = "boat"\nlength_m = -inf',
    b"control_rate_hz = 1e400",
    b"[hull]\nmass_kg = nan",
    b'[[thruster]]\n[[thruster]]\nname = "a"',
    b'[[sensor]]\nname = "s"\ndriver = "nmea0183"\nport = "serial:"',
    b"[[actuator]]\nport = 3\nthrusters = [[], {}]",
    b"operators = [99999999999999999999]",
    b'links = ["tcpin:0.0.0.0:99999?signing=x"]',
    b"a = " + b"[" * 300 + b"]" * 300,
    b"[home]\nlat_deg = 91\n[home]\n",
    b"\xff\xfe\x00[hull",
    b"x = 2026-06-01T12:00:00Z\n'' = 1",
)


def _vessels() -> Iterator[bytes]:
    yield from _PARTS
    for path in resources.files("companion.vessels").iterdir():
        if path.name.endswith(".toml"):
            yield path.read_bytes()


SEEDS: Mapping[str, Callable[[], Iterator[bytes]]] = {
    "framer": _framer,
    "mission_transfer": _mission,
    "ftp": _ftp,
    "nmea": _nmea,
    "mtdata2": _mtdata2,
    "sbus": _sbus,
    "crsf": _crsf,
    "plan_file": _plans,
    "vessel_file": _vessels,
}
