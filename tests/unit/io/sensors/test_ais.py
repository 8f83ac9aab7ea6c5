"""AIS sentences as transponders on the water send them, and as a bad line or a bad peer may make them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.config.devices import SensorConfig
from companion.core.readings import AisTarget, Reading
from companion.io.sensors.ais import AisReceiver
from sitl.memory import MemoryStream
from tests.remembered import remembered

KNOT = 1852.0 / 3600.0
# of E. S. Raymond's AIVDM/AIVDO document and the test data of gpsd, off the air
CLASS_A = b"!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C\r\n"
CLASS_A_SLOW = b"!AIVDM,1,1,,B,15M67FC000G?ufbE`FepT@3n00Sa,0*5C\r\n"
STATIC = (
    b"!AIVDM,2,1,1,A,55?MbV02;H;s<HtKR20EHE:0@T4@Dn2222222216L961O5Gf0NSQEp6ClRp8,0*1C\r\n",
    b"!AIVDM,2,2,1,A,88888888880,2*25\r\n",
)
CLASS_B = b"!AIVDM,1,1,,A,B52KlJP00=l4be5ItJ6r3wVUWP06,0*7C\r\n"
NAME_B = b"!AIVDM,1,1,,A,H42O55i18tMET00000000000000,2*6D\r\n"
SHIP_B = b"!AIVDM,1,1,,A,H42O55lt0000000D3nink000?0500,0*70\r\n"


def field(sentence: bytes, begin: int, width: int, signed: bool = False) -> int:
    """Bits of a one-sentence message, read by hand."""
    values = [code - 48 - (8 if code > 88 else 0) for code in sentence.split(b",")[5]]
    bits = "".join(f"{value:06b}" for value in values)[begin : begin + width]
    return int(bits, 2) - (1 << width if signed and bits[0] == "1" else 0)


def heard(*chunks: bytes, latency_s: float = 0.0) -> tuple[list[Reading], AisReceiver]:
    stream = MemoryStream("ais")
    receiver = AisReceiver(SensorConfig(name="ais", driver="ais", port="memory:ais", latency_s=latency_s), stream)
    readings: list[Reading] = []
    for n, chunk in enumerate(chunks):
        stream.device.send(chunk, 0.1 * n)
        readings += receiver.read(0.1 * n)
    return readings, receiver


def one(*chunks: bytes) -> AisTarget:
    readings, _ = heard(*chunks)
    assert len(readings) == 1 and isinstance(readings[0], AisTarget)
    return readings[0]


def test_a_report_of_class_a() -> None:
    """The values that the document prints for this sentence."""
    target = one(CLASS_A)
    assert target.mmsi == 477553000 and target.status == 5
    assert (target.lat_deg, target.lon_deg) == pytest.approx((47.582833, -122.345833), abs=1e-6)
    assert target.speed_mps == 0.0 and target.course_rad == pytest.approx(math.radians(51.0))
    assert target.heading_rad == pytest.approx(math.radians(181.0)) and target.turn_rate_radps == 0.0
    assert target.name is None and target.bow_m is None


def test_what_a_ship_says_of_itself_comes_in_two_sentences() -> None:
    target = one(*STATIC)
    assert (target.mmsi, target.name, target.callsign, target.kind) == (351759000, "EVER DIADEM", "3FOF8", 70)
    assert (target.bow_m, target.stern_m, target.port_m, target.starboard_m) == (225.0, 70.0, 1.0, 31.0)
    assert target.lat_deg is None and target.speed_mps is None and target.t_s == 0.0


def test_reports_of_class_b() -> None:
    target = one(CLASS_B)
    assert target.mmsi == field(CLASS_B, 8, 30) == 338097258
    assert (target.lat_deg, target.lon_deg) == pytest.approx(
        (field(CLASS_B, 85, 27) / 600_000, field(CLASS_B, 57, 28, True) / 600_000), abs=1e-6
    )
    assert target.speed_mps == pytest.approx(0.1 * KNOT * field(CLASS_B, 46, 10))
    assert target.course_rad == pytest.approx(math.radians(0.1 * field(CLASS_B, 112, 12)))
    assert target.heading_rad is None and target.status is None
    assert one(NAME_B).name == "PROGUY"
    ship = one(SHIP_B)
    assert ship.callsign == "TC6163" and (ship.bow_m, ship.stern_m, ship.port_m, ship.starboard_m) == (
        0.0,
        15.0,
        0.0,
        5.0,
    )


def test_sentences_are_found_wherever_the_stream_is_cut() -> None:
    line = b"$GPGGA,,,,,,0,,,,,,,,*66\r\n\\s:r3,c:1241544035*4A\\" + CLASS_A + STATIC[0] + STATIC[1]
    for cut in range(1, len(line)):
        readings, _ = heard(line[:cut], line[cut:])
        assert [reading.mmsi for reading in readings if isinstance(reading, AisTarget)] == [477553000, 351759000], cut


def test_a_wrong_checksum_and_a_missing_one_are_not_trusted() -> None:
    readings, receiver = heard(CLASS_A.replace(b"*5C", b"*5D"), CLASS_A.replace(b"*5C", b""))
    assert readings == [] and "1 bad" in receiver.health(1.0).text


def test_the_own_transponder_is_no_traffic() -> None:
    assert heard(b"!AIVDO,1,1,,,B00000000868rA6<H7KNswPUoP06,0*6A\r\n")[0] == []


def test_parts_that_do_not_belong_together_make_no_ship() -> None:
    stream = MemoryStream("ais")
    receiver = AisReceiver(SensorConfig(name="ais", driver="ais", port="memory:ais"), stream)
    stream.device.send(STATIC[0], 0.0)
    assert list(receiver.read(0.0)) == []
    stream.device.send(STATIC[1], 60.0)
    assert list(receiver.read(60.0)) == []
    stream.device.send(STATIC[1], 61.0)
    assert list(receiver.read(61.0)) == []


def test_begun_messages_are_not_kept_for_ever() -> None:
    from sitl.emulators.nmea import checksum_text

    bodies = [
        f"AIVDM,{total},1,{seq},{channel},55,0" for total in range(2, 10) for seq in range(10) for channel in "AB"
    ]
    _, receiver = heard("".join(f"!{body}*{checksum_text(body)}\r\n" for body in bodies).encode())
    assert remembered(receiver) < 16 * 100, "160 have begun"


def test_latency_is_taken_out() -> None:
    readings, _ = heard(b"", CLASS_A, latency_s=0.06)
    assert readings[0].t_s == pytest.approx(0.04)


def test_an_empty_sea_is_no_fault_but_nonsense_is() -> None:
    _, receiver = heard(CLASS_A)
    assert receiver.health(1000.0).ok
    _, quiet = heard()
    assert quiet.health(1000.0).ok
    _, babbled = heard(b"\x00\xff" * 400)
    assert not babbled.health(1.0).ok


@given(
    st.binary(max_size=200),
    st.text(alphabet="0123456789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVW`abcdefghijklmnopqrstuvw", min_size=1, max_size=60),
)
def test_no_payload_stops_it(noise: bytes, payload: str) -> None:
    from sitl.emulators.nmea import checksum_text

    body = f"AIVDM,1,1,,A,{payload},0"
    readings, _ = heard(noise + b"\n" + f"!{body}*{checksum_text(body)}\r\n".encode())
    for reading in readings:
        assert isinstance(reading, AisTarget) and (reading.lat_deg is None or abs(reading.lat_deg) <= 90.0)
