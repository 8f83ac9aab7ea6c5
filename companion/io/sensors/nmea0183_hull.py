"""NMEA 0183 sentences of what is measured aboard: headings, wind, water, rudder, transducers."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping

from companion.config.devices import SensorConfig
from companion.core.angles import wrap_pi
from companion.core.readings import Depth, DepthAhead, Heading, HeadingBy, Measurement, Reading, Wind
from companion.io.sensors.nmea0183_fields import (
    MPS,
    TALKER,
    Sentence,
    angle_rad,
    not_negative,
    number,
    signed,
    within_turn,
)
from companion.io.sensors.nmea0183_gnss import Handler

_MAGNETIC_COMPASS = "HC"
_LASTS_S = 2.0  # a heading, as a reason to leave a lesser one aside
_FOOT_M, _FATHOM_M = 0.3048, 1.8288
_MOST_TRANSDUCERS = 10  # in one XDR
TRANSDUCERS = tuple(
    f"{part}_{n}" for n in range(_MOST_TRANSDUCERS) for part in ("type", "value", "units", "id")
)  # fields of an XDR
# type and unit of a transducer → (ending of the name, factor to SI; degrees Celsius stay)
_TRANSDUCER_UNITS = {
    ("A", "D"): ("rad", math.pi / 180.0),
    ("C", "C"): ("c", 1.0),
    ("D", "M"): ("m", 1.0),
    ("P", "B"): ("pa", 1e5),
    ("P", "P"): ("pa", 1.0),
    ("P", "H"): ("pa", 100.0),
    ("H", "P"): ("share", 0.01),
    ("U", "V"): ("v", 1.0),
    ("I", "A"): ("a", 1.0),
    ("F", "H"): ("hz", 1.0),
    ("T", "R"): ("radps", math.tau / 60.0),
    ("N", "N"): ("n", 1.0),
}


def replaces_lesser(kind: str, sentence: Sentence) -> bool:
    """Whether the sentence holds what lesser ones tell too. VWR and VHW may come beside a MWV of true wind, and beside
    a VBW with the speed over ground alone; GLL and RMC beside a GNS of one constellation, which has no place."""
    if kind == "MWV":
        return sentence.get("reference") == "R"
    if kind == "GNS":
        return bool(sentence.get("mode_indicator"))
    return kind != "VBW" or bool(sentence.get("lon_water_spd"))


class HullSentences:
    """HDT, THS, HDG, HDM → `Heading`; MWV, VWR → `Wind`; DPT, DBT → `Depth`, or `DepthAhead` of a
    sounder that looks ahead; ROT, VHW, VBW, RSA, XDR → `Measurement`.

    `recent(kind, t_s)`: whether that sentence has come lately; HDM, VWR and DBT count only where nothing better does,
    nor do HDT and THS of a magnetic compass. HDG and HDM of a talker that tells a true heading are made of that, and
    no witness of it: they do not count. Remembers when each talker last told a true heading, and when a HDG counted.
    """

    def __init__(self, config: SensorConfig, recent: Callable[[str, float], bool]) -> None:
        self._name = config.name
        self._offset_rad = config.heading_offset_rad
        self._ahead_m = config.depth_ahead_m
        self._recent = recent
        self._true_s: dict[str, float] = {}
        self._hdg_s = -math.inf
        self.handlers: Mapping[str, Handler] = {
            "HDT": self._hdt,
            "THS": self._ths,
            "HDG": self._hdg,
            "HDM": self._hdm,
            "MWV": self._mwv,
            "VWR": self._vwr,
            "DPT": self._dpt,
            "DBT": self._dbt,
            "ROT": self._rot,
            "VHW": self._vhw,
            "VBW": self._vbw,
            "RSA": self._rsa,
            "XDR": self._xdr,
        }

    # --- headings ---------------------------------------------------------------------------------------------------

    def _hdt(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        self._true(sentence, t_s, readings)

    def _ths(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        if sentence.get("mode") == "A":
            self._true(sentence, t_s, readings)

    def _true(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """Of two antennas, or of a magnetic compass that knows the variation: its talker tells."""
        heading = within_turn(sentence.get("heading"))
        if heading is None:
            return
        if (talker := sentence[TALKER]) != _MAGNETIC_COMPASS:
            self._true_s[talker] = t_s
            self._heading(heading, HeadingBy.BASELINE, t_s, readings)
        elif t_s - self._hdg_s >= _LASTS_S:
            self._heading(heading, HeadingBy.COMPASS, t_s, readings)

    def _hdg(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """Magnetic; true already where the compass knows the variation."""
        heading = within_turn(sentence.get("heading"))
        if heading is None or self._is_derived(sentence, t_s):
            return
        self._hdg_s = t_s
        heading += signed(sentence.get("deviation"), sentence.get("dev_dir")) or 0.0
        variation = signed(sentence.get("variation"), sentence.get("var_dir"))
        if variation is None:
            self._heading(heading, HeadingBy.MAGNETIC, t_s, readings)
        else:
            self._heading(heading + variation, HeadingBy.COMPASS, t_s, readings)

    def _hdm(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        heading = within_turn(sentence.get("heading"))
        if t_s - self._hdg_s >= _LASTS_S and not self._is_derived(sentence, t_s):
            self._heading(heading, HeadingBy.MAGNETIC, t_s, readings)

    def _is_derived(self, sentence: Sentence, t_s: float) -> bool:
        """Whether a magnetic heading is the true one of the same device, less the variation."""
        return t_s - self._true_s.get(sentence[TALKER], -math.inf) < _LASTS_S

    def _heading(self, heading_deg: float | None, by: HeadingBy, t_s: float, readings: list[Reading]) -> None:
        if heading_deg is not None:
            yaw_rad = wrap_pi(math.radians(heading_deg) + self._offset_rad)
            readings.append(Heading(t_s, self._name, yaw_rad, None, by))

    # --- wind and water ---------------------------------------------------------------------------------------------

    def _mwv(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """Relative wind of a valid sentence only."""
        if sentence.get("status") != "A" or sentence.get("reference") != "R":
            return
        angle, speed = within_turn(sentence.get("wind_angle")), not_negative(sentence.get("wind_speed"))
        unit = MPS.get(sentence.get("wind_speed_units", ""))
        if angle is not None and speed is not None and unit is not None:
            readings.append(Wind(t_s, self._name, speed * unit, wrap_pi(math.radians(angle) + self._offset_rad)))

    def _vwr(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """0…180° to the left or right of the bow."""
        angle, side = within_turn(sentence.get("deg_r")), sentence.get("l_r")
        units = (("wind_speed_ms", "M"), ("wind_speed_kn", "N"), ("wind_speed_km", "K"))
        speeds = [speed * MPS[unit] for name, unit in units if (speed := not_negative(sentence.get(name))) is not None]
        if angle is None or side not in ("L", "R") or not speeds or self._recent("MWV", t_s):
            return
        from_rad = math.radians(angle if side == "R" else -angle)
        readings.append(Wind(t_s, self._name, speeds[0], wrap_pi(from_rad + self._offset_rad)))

    def _dpt(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        depth = number(sentence.get("depth"))
        if depth is None or depth <= 0.0:  # 0: many sounders say so that they find no bottom
            return
        if self._ahead_m > 0.0:
            readings.append(DepthAhead(t_s, self._name, depth, self._ahead_m))
            return
        readings.append(Depth(t_s, self._name, depth, number(sentence.get("offset")), number(sentence.get("range"))))

    def _dbt(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        units = (("depth_meters", 1.0), ("depth_feet", _FOOT_M), ("depth_fathoms", _FATHOM_M))
        depths = [depth * unit for name, unit in units if (depth := number(sentence.get(name))) is not None]
        if not depths or depths[0] <= 0.0 or self._recent("DPT", t_s):
            return
        if self._ahead_m > 0.0:
            readings.append(DepthAhead(t_s, self._name, depths[0], self._ahead_m))
        else:
            readings.append(Depth(t_s, self._name, depths[0]))

    def _vhw(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        speed, unit = number(sentence.get("water_speed_knots")), MPS["N"]
        if speed is None:
            speed, unit = number(sentence.get("water_speed_km")), MPS["K"]
        if not self._recent("VBW", t_s):
            self._measured("water_surge_mps", speed, unit, t_s, readings)

    def _vbw(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """Through the water, ahead and to starboard; over ground a receiver knows better."""
        if sentence.get("data_validity_water_spd") == "A":
            self._measured("water_surge_mps", number(sentence.get("lon_water_spd")), MPS["N"], t_s, readings)
            self._measured("water_sway_mps", number(sentence.get("trans_water_spd")), MPS["N"], t_s, readings)

    # --- the rest ---------------------------------------------------------------------------------------------------

    def _rot(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """Degrees a minute, positive to starboard."""
        if sentence.get("status") == "A":
            self._measured("rate_of_turn_radps", angle_rad(sentence.get("rate_of_turn")), 1.0 / 60.0, t_s, readings)

    def _rsa(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """A single rudder stands in the place of the starboard one; positive turns the boat to starboard."""
        for side, name in (("starboard", "rudder_rad"), ("port", "rudder_port_rad")):
            if sentence.get(f"rsa_{side}_status") == "A":
                self._measured(name, angle_rad(sentence.get(f"rsa_{side}")), 1.0, t_s, readings)

    def _xdr(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        for n in range(_MOST_TRANSDUCERS):
            kind, unit, name = (sentence.get(f"{part}_{n}", "") for part in ("type", "units", "id"))
            ending, factor = _TRANSDUCER_UNITS.get((kind, unit), ("", 1.0))
            if not name or name.isdecimal():  # weather stations number the transducers of each kind
                name = kind + name
            known = re.sub("[^a-z0-9]+", "_", name.lower())[:24].strip("_")
            if known:
                self._measured(
                    f"{known}_{ending}" if ending else known, number(sentence.get(f"value_{n}")), factor, t_s, readings
                )

    def _measured(self, name: str, value: float | None, unit: float, t_s: float, readings: list[Reading]) -> None:
        if value is not None:
            readings.append(Measurement(t_s, self._name, value * unit, name))
