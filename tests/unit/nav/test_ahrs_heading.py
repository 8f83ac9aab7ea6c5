"""A raw magnetometer as the estimator's heading: calibration, mounting, the course, sources that fail."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from companion.baselines.ahrs import ThesisAhrs
from companion.config import vessel as vessel_config
from companion.config.devices import SensorConfig
from companion.config.vessel import VesselConfig
from companion.core.decision import TextKind
from companion.core.estimate import NavState
from companion.core.geodesy import LocalFrame
from companion.core.geomagnetism import declination_rad, field_nt
from companion.core.readings import FixType, GnssFix, GroundVelocity, Heading, HeadingBy, Imu, MagneticField, Reading
from companion.nav.ahrs_heading import AhrsHeading, ahrs_headings
from companion.nav.corrections import SensorCorrections, corrections_of
from companion.nav.estimator import Estimator
from companion.nav.headings import HeadingSources
from companion.params.store import Parameters
from tests.unit.nav.ahrs_motion import DECLINATION_RAD, GRAVITY_MPS2, Motion, Sailing, sail

ROW = SensorConfig(
    name="imu", driver="mtdata2", port="memory:imu", heading="ahrs", heading_wander_rad=math.radians(1.0)
)
STRAIGHT = ((32.0, 8.0, 0.0),)
GOTHENBURG = (57.69, 11.80)


def heading_of(row: SensorConfig, parameters: Parameters) -> AhrsHeading:
    return AhrsHeading(row, GRAVITY_MPS2, parameters, corrections_of([row], parameters)[row.name], ThesisAhrs)


def correction(
    parameters: dict[str, float],
    mounting_rad: float = math.radians(45.0),
    row: SensorConfig = ROW,
    astern: bool = False,
) -> tuple[AhrsHeading, float, float]:
    """A straight run at 8 m/s of a device turned in its mounting: (the source, heading error in degrees at 10 s and 30
    s). `astern`: the boat may go stern first."""
    motion = sail(
        Sailing(parts=STRAIGHT, mounting_rad=mounting_rad, wave_rad=math.radians(2.0), wave_m=0.1, iron=0.0, slip_s=0.0)
    )
    ahrs, errors = heading_of(row, Parameters(parameters)), {}
    for k, t_s in enumerate(motion.t_s.tolist()):
        heading = ahrs.imu(Imu(t_s, "imu", *motion.force[k].tolist(), *motion.rates[k].tolist()))
        if k % 4 == 0:
            ahrs.field(MagneticField(t_s, "imu", *motion.field[k].tolist()), DECLINATION_RAD)
        if k % 20 == 0:
            ahrs.velocity(t_s, *motion.velocity[k].tolist(), 0.06, (0.0, 0.0, 0.0), astern)
        if heading is not None:
            errors[round(t_s)] = math.degrees(math.remainder(heading.yaw_rad - motion.yaw_rad[k], 2 * math.pi))
    return ahrs, errors[10], errors[30]


@pytest.mark.parametrize("parameters", [{"AHRS_LAW": 1.0}, {"AHRS_DRIFT": 0.0}], ids=["thesis", "companion"])
def test_a_mounting_error_of_45_degrees_is_a_third_corrected_in_20_s(parameters: dict[str, float]) -> None:
    ahrs, before, after = correction(parameters)
    assert abs(before) == pytest.approx(45.0, abs=3.0)
    assert 1.0 - after / before == pytest.approx(1.0 - math.exp(-0.4), abs=0.05)
    assert abs(math.degrees(ahrs.corrected_rad)) == pytest.approx(45.0 * (1.0 - math.exp(-0.4)), abs=2.0)


def test_a_difference_that_drift_explains_is_not_corrected() -> None:
    ahrs, _, _ = correction({}, math.radians(3.0))
    assert abs(math.degrees(ahrs.corrected_rad)) < 0.2
    ahrs, _, _ = correction({"AHRS_COURSE_T": 0.0})
    assert ahrs.corrected_rad == 0.0


def test_no_heading_is_drawn_to_the_course_of_a_boat_that_may_go_stern_first() -> None:
    ahrs, _, _ = correction({}, astern=True)
    assert ahrs.corrected_rad == 0.0


def test_a_configured_mounting_angle_is_removed() -> None:
    _, before, _ = correction({}, math.radians(45.0), replace(ROW, heading_offset_rad=math.radians(45.0)))
    _, negative, _ = correction({}, math.radians(45.0), replace(ROW, heading_offset_rad=math.radians(-45.0)))
    assert min(abs(before), abs(negative)) < 2.0


def test_calibration_is_offset_first_then_matrix() -> None:
    row = replace(ROW, mag_offset=(1.0, 2.0, 3.0), mag_matrix=((2.0, 0.0, 0.0), (0.0, 3.0, 1.0), (0.0, 1.0, 4.0)))
    corrections = SensorCorrections(row, Parameters(), None, None)
    assert corrections.field(MagneticField(0.0, "imu", 2.0, 2.5, 2.0)) == (2.0, 0.5, -3.5)


def test_without_a_field_for_2_s_there_is_no_heading() -> None:
    ahrs = heading_of(ROW, Parameters())
    given = []
    for k in range(600):
        t_s = 0.01 * k
        if t_s < 3.0:
            ahrs.field(MagneticField(t_s, "imu", 0.35, 0.0, 0.9), 0.0)
        heading = ahrs.imu(Imu(t_s, "imu", 0.0, 0.0, -9.81, 0.0, 0.0, 0.0))
        if heading is not None:
            assert heading.by is HeadingBy.COMPASS and heading.accuracy_rad is not None
            given.append(t_s)
    assert given[0] == pytest.approx(1.0, abs=0.2) and given[-1] == pytest.approx(5.0, abs=0.15)
    assert len(given) == pytest.approx(40, abs=3)


@pytest.mark.parametrize("off_deg", [10.0, 180.0])
def test_the_heading_by_the_field_alone_knows_nothing_of_the_gyro(off_deg: float) -> None:
    """A field that is turned, beside a gyro that is not: the filter takes its time."""
    ahrs, off_rad, before, after = heading_of(ROW, Parameters()), math.radians(off_deg), [], []
    assert ahrs.by_field_rad is None
    for k in range(400):
        t_s, angle_rad = 0.01 * k, 0.0 if k < 300 else off_rad
        noise = 0.002 * (-1.0) ** k
        ahrs.field(MagneticField(t_s, "imu", 0.35 * math.cos(angle_rad), -0.35 * math.sin(angle_rad) + noise, 0.9), 0.0)
        heading = ahrs.imu(Imu(t_s, "imu", 0.0, 0.0, -9.81, 0.0, 0.0, 0.0))
        if heading is not None and ahrs.by_field_rad is not None:
            (before if k < 300 else after).append((ahrs.by_field_rad, heading.yaw_rad))
    assert all(abs(by_field) < 0.005 and abs(yaw) < 0.005 for by_field, yaw in before[1:])
    by_field, yaw = after[2]
    assert abs(math.remainder(by_field - off_rad, 2.0 * math.pi)) < 0.02 and abs(yaw) < 0.3 * off_rad


@pytest.mark.parametrize(("forces", "rates"), [(False, True), (True, False)], ids=["no forces", "no gyro"])
def test_a_part_that_lies_does_not_take_the_heading_with_it(forces: bool, rates: bool) -> None:
    """Turned by 60 deg after 2 s; what lies is what nobody would measure there."""
    ahrs, given = heading_of(ROW, Parameters()), []
    for k in range(500):
        t_s = 0.01 * k
        turning = 3.0 <= t_s < 4.0
        yaw_rad = math.radians(60.0) * min(max(t_s - 3.0, 0.0), 1.0)
        if k == 200:
            ahrs.trust(forces, rates)
        force = (0.0, 0.0, -9.81) if k < 200 or rates else (0.3 * math.sin(t_s), 0.0, -9.81)
        turn_radps = (math.radians(60.0) * turning) if rates else (4.0 if k >= 200 else 0.0)
        ahrs.field(MagneticField(t_s, "imu", 0.35 * math.cos(yaw_rad), -0.35 * math.sin(yaw_rad), 0.9), 0.0)
        heading = ahrs.imu(Imu(t_s, "imu", *force, 0.0, 0.0, turn_radps))
        if heading is not None:
            given.append((t_s, math.degrees(heading.yaw_rad - yaw_rad), heading.accuracy_rad))
    gaps_s = [after[0] - before[0] for before, after in itertools.pairwise(given)]
    assert max(gaps_s) < 0.35 and given[-1][0] > 4.85
    assert all(abs(off_deg) < 6.0 for t_s, off_deg, _ in given if t_s > 2.0)
    assert all(accuracy is not None and accuracy < math.radians(6.0) for _, _, accuracy in given[-10:])


def test_the_law_can_be_changed_under_way() -> None:
    parameters = Parameters()
    ahrs = heading_of(ROW, parameters)
    for k in range(600):
        if k == 300:
            parameters.set("AHRS_LAW", 1.0)
        ahrs.field(MagneticField(0.01 * k, "imu", 0.0, -0.35, 0.9), 0.0)
        heading = ahrs.imu(Imu(0.01 * k, "imu", 0.0, 0.0, -9.81, 0.0, 0.0, 0.0))
    assert isinstance(ahrs.filter, ThesisAhrs)
    assert heading is None or math.degrees(heading.yaw_rad) == pytest.approx(90.0, abs=0.5)
    assert math.degrees(ahrs.filter.attitude[2]) == pytest.approx(90.0, abs=0.5)


# --- in the estimator ----------------------------------------------------------------------------------------------


def vessel() -> VesselConfig:
    config = vessel_config.load(vessel_config.find("revolt"))
    gnss = replace(config.sensors[0], antennas=1, x_m=-0.8, z_m=-1.0)
    imu = replace(
        config.sensors[1], heading="ahrs", heading_wander_rad=math.radians(1.0), accelerometer_noise_mps2_rthz=0.05
    )
    return replace(config, sensors=(gnss, imu), home=replace(config.home, lat_deg=GOTHENBURG[0], lon_deg=GOTHENBURG[1]))


def navigate(motion: Motion, until_field_s: float = math.inf) -> tuple[list[NavState], list[tuple[TextKind, str]]]:
    config, said = vessel(), []
    estimator = Estimator(config, Parameters(), lambda _t, severity, _name, text: said.append((severity, text)))
    frame, states, batch = LocalFrame(*GOTHENBURG), [], []
    position = np.cumsum(motion.velocity, axis=0) / 200.0
    for k in range(0, len(motion.t_s), 2):
        t_s = float(motion.t_s[k])
        batch.append(Imu(t_s, "imu", *motion.force[k].tolist(), *motion.rates[k].tolist()))
        if k % 4 == 0 and t_s < until_field_s:
            batch.append(MagneticField(t_s, "imu", *motion.field[k].tolist()))
        if k % 20 == 0:
            row: list[Reading] = [
                GnssFix(t_s, "gnss", *frame.to_geodetic(*position[k].tolist()), 0.0, FixType.DGPS, 14, 0.8, 0.5),
                GroundVelocity(t_s, "gnss", *motion.velocity[k].tolist()),
            ]
            states.append(estimator.update([*batch, *row], t_s))
            batch = []
    return states, said


def test_a_raw_magnetometer_is_the_only_heading_of_a_boat() -> None:
    """Switched on under way: until the filter has levelled itself, the course has to do."""
    assert declination_rad(*GOTHENBURG, 2027.5) == pytest.approx(DECLINATION_RAD, abs=math.radians(0.1))
    north, east, down = field_nt(*GOTHENBURG, 2027.5)
    assert math.atan2(east, north) == pytest.approx(declination_rad(*GOTHENBURG, 2027.5)) and down > 0.0
    motion = sail(
        Sailing(
            seed=2,
            iron=0.0015,
            parts=((20.0, 4.0, 0.0), (15.0, 8.0, 0.3), (8.0, 8.0, 0.0), (15.0, 8.0, -0.3), (8.0, 8.0, 0.0)),
        )
    )
    states, said = navigate(motion)
    late = [(state, motion.yaw_rad[20 * k]) for k, state in enumerate(states) if state.t_s > 12.0]
    errors = np.degrees([abs(math.remainder(state.yaw_rad - yaw, 2 * math.pi)) for state, yaw in late])
    assert errors.mean() < 1.0 and errors.max() < 3.0
    assert all(state.heading_valid for state, _ in late)
    assert all(math.radians(0.2) < state.heading_accuracy_rad < math.radians(3.0) for state, _ in late)
    assert [text for _, text in said if text.startswith("Heading")] == [
        "Heading source: course over ground",
        "Heading source: imu compass",
    ]


def test_a_silent_magnetometer_gives_way_to_the_course_and_is_announced() -> None:
    motion = sail(Sailing(parts=((40.0, 6.0, 0.0),), wave_rad=math.radians(2.0)))
    states, said = navigate(motion, until_field_s=20.0)
    assert (TextKind.ATTENTION, "Heading source: course over ground (imu compass lost)") in said
    assert states[-1].heading_valid


def test_a_field_that_is_not_finite_is_ignored() -> None:
    estimator = Estimator(vessel(), Parameters())
    for k in range(300):
        field = (0.35, 0.0, 0.9) if k % 3 else (math.nan, math.inf, 0.0)
        state = estimator.update(
            [Imu(0.01 * k, "imu", 0.0, 0.0, -9.81, 0.0, 0.0, 0.0), MagneticField(0.01 * k, "imu", *field)], 0.01 * k
        )
    assert math.degrees(state.yaw_rad) == pytest.approx(math.degrees(DECLINATION_RAD), abs=0.5)


@pytest.mark.parametrize(
    ("place", "field", "told"),
    [
        (GOTHENBURG, (0.1, 0.0, 0.99), "imu compass unusable: dip of 84 deg"),
        ((86.0, -140.0), (0.02, 0.0, 0.99), "imu compass unusable: near the pole"),
    ],
)
def test_a_field_near_the_poles_gives_no_heading_and_that_is_told(
    place: tuple[float, float], field: tuple[float, float, float], told: str
) -> None:
    boat, said = vessel(), []
    boat = replace(boat, home=replace(boat.home, lat_deg=place[0], lon_deg=place[1]))
    estimator = Estimator(boat, Parameters(), lambda _t, kind, _name, text: said.append((kind, text)))
    for k in range(2000):
        t_s = 0.01 * k
        state = estimator.update(
            [Imu(t_s, "imu", 0.0, 0.0, -9.81, 0.0, 0.0, 0.0), MagneticField(t_s, "imu", *field)], t_s
        )
        assert not state.heading_valid
    assert said == [(TextKind.ATTENTION, told)] and len(told) <= 50


def test_a_field_that_changes_its_strength_counts_for_no_field() -> None:
    """Beside steel the gyro alone carries the heading, and its headings are no compass's."""
    ahrs, given = heading_of(ROW, Parameters()), []
    for k in range(1500):
        t_s, share = 0.01 * k, 1.0 if k < 1000 else 1.5
        ahrs.field(MagneticField(t_s, "imu", 0.35 * share, 0.0, 0.9 * share), 0.0)
        if ahrs.imu(Imu(t_s, "imu", 0.0, 0.0, -9.81, 0.0, 0.0, 0.0)) is not None:
            given.append(t_s)
    assert 11.5 < given[-1] < 12.2


def test_an_uncalibrated_magnetometer_has_a_large_sigma() -> None:
    def accuracy_deg(**changes: object) -> float:
        config = vessel()
        row = replace(config.sensors[1], **changes)  # type: ignore[arg-type]
        sources = HeadingSources(replace(config, sensors=(config.sensors[0], row)), lambda *_: None)
        measured = sources.measured(Heading(0.0, "imu", 1.0, 0.01, HeadingBy.COMPASS), *GOTHENBURG, None)
        assert measured is not None
        found = sources.offer(measured)
        assert found is not None
        return math.degrees(found.slow_sigma_rad)

    assert accuracy_deg(heading_wander_rad=None) == pytest.approx(15.0)
    assert accuracy_deg(heading_wander_rad=None, mag_offset=(0.1, 0.0, 0.0)) == pytest.approx(2.1)
    assert accuracy_deg(heading_wander_rad=0.02) == pytest.approx(math.degrees(0.02))  # calibrated by the device itself
    assert accuracy_deg(heading_wander_rad=None, heading="magnetic") == pytest.approx(2.1)


def test_only_sensors_configured_for_it_get_an_ahrs() -> None:
    parameters, boat = Parameters(), vessel()
    assert list(ahrs_headings(boat, parameters, corrections_of(boat.sensors, parameters))) == ["imu"]
    assert ahrs_headings(vessel_config.load(vessel_config.find("revolt")), parameters, {}) == {}
