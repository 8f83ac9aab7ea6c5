"""Samples of all inertial sensors → those of the one in use, as the filter may take them: calibrated, in body axes,
without forces that lie, and of several sensors aligned or voted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from companion.config.devices import SensorConfig
from companion.core.readings import Imu, Reading
from companion.nav.corrections import SensorCorrections
from companion.nav.inertial import without_force
from companion.nav.inertial_units import inertial_units, silences_s
from companion.nav.integrity.evidence import Sense
from companion.nav.lever_arms import normal_gravity_mps2
from companion.nav.mounting import Mounting
from companion.nav.sources import SourceSelector
from companion.nav.witness import Witness


class InertialSource:
    """Call `corrected`, `felt` and `chosen` for each sample, in that order.

    Remembers the sensor in use, those whose forces lie, the samples that align the others, and which calibration of
    each has been seen.
    """

    def __init__(
        self,
        sensors: Sequence[SensorConfig],
        corrections: Mapping[str, SensorCorrections],
        mounting: Mounting,
        witness: Witness,
    ) -> None:
        self._corrections, self._mounting, self._witness = corrections, mounting, witness
        self._versions = dict.fromkeys(corrections, 0)
        self._selector = SourceSelector(silences_s(sensors))
        self._units = inertial_units(sensors)  # None: there is one inertial sensor at most
        self._unfelt: set[str] = set()

    @property
    def current(self) -> str | None:
        """The sensor in use; None before the first."""
        return self._selector.current

    def voted(self, now_s: float) -> bool:
        """Whether the filter lately got the vote of several sensors, which none of them can spoil."""
        return self._units is not None and self._units.voted(now_s)

    def lies(self, source: str) -> bool:
        """Whether the forces of a sensor lie."""
        return source in self._unfelt

    def corrected(self, imu: Imu) -> Imu:
        """The sample as calibrated, in body axes."""
        self._witness.raw(imu)
        corrections = self._corrections.get(imu.source)
        return self._mounting.turned(imu if corrections is None else corrections.imu(imu))

    def felt(self, measured: Imu, lat_deg: float) -> tuple[Imu, bool | None]:
        """The sample as it is used, without its forces where those lie; and whether the filter is to begin anew with
        forces (True) or without them (False), None: it goes on. `lat_deg`: where gravity is that of."""
        source = measured.source
        if self._witness.trusts(Sense.ACCELEROMETER, source):
            back = source in self._unfelt
            self._unfelt.discard(source)
            return measured, True if back else None
        known = source in self._unfelt
        self._unfelt.add(source)
        stops = not known and not self.voted(measured.t_s)
        return without_force(measured, normal_gravity_mps2(lat_deg)), False if stops else None

    def chosen(self, measured: Imu, felt: Imu) -> Imu | None:
        """The sample for the filter; None if its sensor is not in use."""
        feels, good = felt is measured, self._witness.imu(measured)
        used, units, source = self._selector.offer(felt.source, felt.t_s, good, int(feels)), self._units, felt.source
        if units is None:
            return felt if used else None
        if good and feels and not self._is_anew(source):
            aligned = units.take(felt, used)
            return aligned if used else None
        if not used and self._is_anew(source):
            self._versions[source] = self._corrections[source].version
        units.drop(source)
        return felt if used and (feels or not units.voted(felt.t_s)) else None

    def recalibrated(self, source: str) -> bool:
        """Whether a sensor has been calibrated since its last sample. True once."""
        if not self._is_anew(source):
            return False
        self._versions[source] = self._corrections[source].version
        return True

    def later(self, pending: Sequence[Reading], now_s: float) -> list[Imu]:
        """The samples among `pending` up to now of the sensor in use."""
        later = [reading for reading in pending if type(reading) is Imu and reading.t_s <= now_s]
        units, used = self._units, self.current
        return later if units is None else [units.aligned(imu) for imu in later if imu.source == used]

    def _is_anew(self, source: str) -> bool:
        corrections = self._corrections.get(source)
        return corrections is not None and corrections.version != self._versions[source]
