"""Which ranging sensors fall silent, and which of their beams."""

from __future__ import annotations

import math

from companion.config.vessel import find, load
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.readings import Ranges
from companion.obstacles.surroundings import Surroundings
from companion.params.store import Parameters
from tests.unit.conftest import AT_REST

BEAMS_DEG = (0.0, 90.0, 270.0)
TICK_S = 0.1


class Bench:
    """A sensor `lidar` with three single beams, as three DISTANCE_SENSORs on one port, and a scanning `radar`."""

    def __init__(self) -> None:
        self.events = EventLog()
        frame = LocalFrame(63.4, 10.4)
        self.around = Surroundings(load(find("revolt")), Parameters(), self.events, lambda: frame)
        self.t_s = 0.0

    def run(self, duration_s: float, *beams_deg: float, scans: bool = True) -> list[str]:
        """Only these beams speak. Returns what is said meanwhile."""
        for _ in range(round(duration_s / TICK_S)):
            self.t_s += TICK_S
            for deg in beams_deg:
                self._hear("lidar", math.radians(deg), 1)
            if scans:
                self._hear("radar", 0.0, 72)
            self.around.update(AT_REST, None, self.t_s)
        return [event.text for event in self.events.drain()]

    def see(self, distances_m: dict[int, float]) -> None:
        """One scan all around; `distances_m` by sector of 5 degrees from the bow on."""
        self.t_s += TICK_S
        self._hear("radar", 0.0, 72, distances_m)
        self.around.update(AT_REST, None, self.t_s)

    def _hear(self, name: str, first_rad: float, count: int, distances_m: dict[int, float] | None = None) -> None:
        step_rad = math.radians(5.0)
        seen = tuple((distances_m or {}).get(sector, math.inf) for sector in range(count))
        self.around.take(Ranges(self.t_s, name, first_rad, step_rad, 0.2, 20.0, False, 0.0, 0.0, seen), self.t_s)


def test_one_beam_of_several_on_a_port_falls_silent_alone() -> None:
    bench = Bench()
    assert bench.run(3.0, *BEAMS_DEG) == []
    assert bench.around.silent == ()
    assert bench.run(3.0, 90.0, 270.0) == ["No ranges from lidar at 0 deg"]
    assert bench.around.silent == ("lidar at 0 deg",)
    assert bench.run(3.0, *BEAMS_DEG) == ["Ranges from lidar are back"]
    assert bench.around.silent == ()


def test_a_sensor_whose_beams_are_all_silent_is_named_once() -> None:
    bench = Bench()
    bench.run(3.0, *BEAMS_DEG)
    assert bench.run(3.0) == ["No ranges from lidar"]
    assert bench.run(3.0, 90.0) == []
    assert bench.around.silent == ("lidar at 0 deg", "lidar at 270 deg")
    assert bench.run(3.0, *BEAMS_DEG) == ["Ranges from lidar are back"]
    assert bench.run(3.0, *BEAMS_DEG, scans=False) == ["No ranges from radar"]


def test_where_a_silent_beam_looked_nothing_is_known_to_be_free() -> None:
    bench = Bench()
    bench.run(3.0, *BEAMS_DEG, scans=False)
    assert math.isinf(bench.around.sectors_m(AT_REST)[0])
    bench.run(3.0, 90.0, 270.0, scans=False)
    sectors_m = bench.around.sectors_m(AT_REST)
    assert math.isnan(sectors_m[0]) and math.isinf(sectors_m[18])


def test_a_beam_that_is_swept_to_and_fro_is_no_silent_one() -> None:
    """0.8 s in each of five directions, which it leaves for up to 5.6 s."""
    bench = Bench()
    said: list[str] = []
    for deg in 5 * (270.0, 315.0, 0.0, 45.0, 90.0, 45.0, 0.0, 315.0):
        said += bench.run(0.8, deg, scans=False)
        assert bench.around.silent == ()
    assert said == []
    assert bench.run(3.0, scans=False) == ["No ranges from lidar"]
    assert bench.around.silent == ("lidar",)
    assert bench.run(0.8, 0.0, scans=False) == ["Ranges from lidar are back"]
    assert bench.around.silent == ()


def test_a_beam_that_stood_still_before_it_is_swept_is_missed_once() -> None:
    bench = Bench()
    said = bench.run(10.0, 0.0, scans=False)
    for deg in 5 * (45.0, 90.0, 45.0, 0.0, 315.0, 270.0, 315.0, 0.0):
        said += bench.run(0.8, deg, scans=False)
    assert said == ["No ranges from lidar at 0 deg", "Ranges from lidar are back"]
    assert bench.around.silent == ()


def test_a_false_echo_stops_the_boat_and_lays_no_other_way() -> None:
    bench = Bench()
    bench.run(1.0)
    bench.see({0: 4.0})
    assert len(bench.around.all_circles(bench.t_s)) == 1 and not len(bench.around.lying(bench.t_s))
    bench.see({0: 4.0})
    assert len(bench.around.lying(bench.t_s)) == 1
    for _ in range(3):
        bench.see({})
    assert not len(bench.around.all_circles(bench.t_s))


def scans_of(distance_m: float, sectors: int = 72) -> tuple[list[str], Surroundings]:
    """What is said of a lidar whose sectors all tell the same for 5 s, then 8 m for 1 s."""
    bench, said = Bench(), []
    for told_m in [distance_m] * 50 + [8.0] * 10:
        bench.t_s += TICK_S
        seen = (told_m,) * sectors
        bench.around.take(Ranges(bench.t_s, "lidar", 0.0, 0.1, 0.2, 20.0, False, 0.0, 0.0, seen), bench.t_s)
        bench.around.update(AT_REST, None, bench.t_s)
        said += [event.text for event in bench.events.drain()]
    return said, bench.around


def test_a_lidar_that_knows_nothing_of_any_direction_is_blind() -> None:
    """It speaks, so it counted as heard: the boat went on as if the water were open."""
    said, around = scans_of(math.nan)
    assert said == ["lidar is blind: all its ranges are unknown", "Ranges from lidar are back"]
    assert around.silent == ()
    bench = Bench()
    for _ in range(30):
        bench.t_s += TICK_S
        bench.around.take(Ranges(bench.t_s, "lidar", 0.0, 0.1, 0.2, 20.0, False, 0.0, 0.0, (math.nan,) * 72), bench.t_s)
        bench.around.update(AT_REST, None, bench.t_s)
    assert bench.around.silent == ("lidar",) and bench.around.reach_m == 0.0


def test_a_lidar_that_sees_open_water_is_not_blind() -> None:
    assert scans_of(math.inf)[0] == []


def test_a_single_beam_without_an_echo_is_not_blind() -> None:
    """It cannot tell open water from that."""
    assert scans_of(math.nan, sectors=1)[0] == []
