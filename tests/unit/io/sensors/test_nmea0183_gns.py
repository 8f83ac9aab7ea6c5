"""GNS, as makers' manuals print it, beside the other sentences with a position."""

from __future__ import annotations

import math

import pytest

from companion.core.readings import Corrections, FixType, GnssFix, GroundVelocity, TimeOfDay
from tests.unit.io.sensors.test_nmea0183 import GGA, RMC, read, sentence

# of one epoch, with the checksums that the manual prints: the second and the third tell of one constellation each
ALL = b"$GNGNS,014035.00,4332.69262,S,17235.48549,E,RR,13,0.9,25.63,11.24,,*70\r\n"
GPS = b"$GPGNS,014035.00,,,,,,8,,,,1.0,23*76\r\n"
GLONASS = b"$GLGNS,014035.00,,,,,,5,,,,1.0,23*67\r\n"
UBLOX = b"$GNGNS,103600.01,5114.51176,N,00012.29380,W,ANNN,07,1.18,111.5,45.6,,,V*00\r\n"


def modes(letters: str) -> bytes:
    return sentence(f"GNGNS,120000.00,6326.33401,N,01023.94001,E,{letters},12,0.8,10.4,40.0,,,V")


def test_gns_by_hand() -> None:
    (fix,) = read(UBLOX)
    assert isinstance(fix, GnssFix)
    assert (fix.lat_deg, fix.lon_deg) == pytest.approx((51.0 + 14.51176 / 60.0, -12.29380 / 60.0))
    assert (fix.t_s, fix.source, fix.fix, fix.satellites, fix.hdop, fix.altitude_m) == (
        1.0,
        "gnss",
        FixType.FIX_3D,
        7,
        1.18,
        111.5,
    )
    assert fix.position_accuracy_m == pytest.approx(1.5 * 1.18)


def test_those_of_one_constellation_tell_the_age_of_the_corrections() -> None:
    fix, corrections = read(ALL + GPS + GLONASS)
    assert isinstance(fix, GnssFix) and (fix.fix, fix.satellites) == (FixType.RTK_FIXED, 13)
    assert (fix.lat_deg, fix.lon_deg) == pytest.approx((-(43.0 + 32.69262 / 60.0), 172.0 + 35.48549 / 60.0))
    assert corrections == Corrections(1.0, "gnss", 1.0, 23)
    assert read(modes("AA") + GPS)[1:] == []


@pytest.mark.parametrize(
    "letters, kind",
    [
        ("AN", FixType.FIX_3D),
        ("NA", FixType.FIX_3D),
        ("P", FixType.FIX_3D),
        ("ADNN", FixType.DGPS),
        ("NFFN", FixType.RTK_FLOAT),
        ("FR", FixType.RTK_FIXED),
        ("RRNN", FixType.RTK_FIXED),
        *((letters, FixType.NONE) for letters in ("NN", "EE", "M", "SN", "NNNN")),
    ],
)
def test_the_best_constellation_tells_the_kind_of_fix(letters: str, kind: FixType) -> None:
    (fix,) = read(modes(letters))
    assert isinstance(fix, GnssFix) and fix.fix is kind
    assert math.isnan(fix.lat_deg) == (kind is FixType.NONE)


def test_no_fix_is_reported_without_a_place() -> None:
    (fix,) = read(sentence("GNGNS,120000.00,,,,,NN,00,99.99,,,,,V"))
    assert isinstance(fix, GnssFix) and (fix.fix, fix.satellites) == (FixType.NONE, 0)


def test_an_epoch_counts_once() -> None:
    """GGA before GNS, and GNS before GLL and RMC."""
    gll = sentence("GPGLL,5321.6802,N,00630.3372,W,092750.000,A,A")
    assert len(read(GGA + UBLOX)) == 1
    gga, corrections = read(GGA + ALL + GPS, sentence("GPGGA,092751.000,,,,,0,0,,,M,,M,,") + GPS)
    assert isinstance(gga, GnssFix) and isinstance(corrections, GnssFix)
    assert [type(reading) for reading in read(UBLOX + gll + RMC)] == [GnssFix, GroundVelocity, TimeOfDay]


def test_one_of_a_single_constellation_silences_nothing() -> None:
    assert [type(reading) for reading in read(GPS + RMC)] == [GnssFix, GroundVelocity, TimeOfDay]
