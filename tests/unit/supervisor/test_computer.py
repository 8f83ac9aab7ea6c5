"""Late ticks, told from the times of the ticks alone."""

from __future__ import annotations

from companion.core.events import EventLog
from companion.params.store import Parameters
from companion.supervisor.computer import MANY, WINDOW_S, ComputerWatch

PERIOD_S = 0.1


class Watched:
    def __init__(self) -> None:
        self.parameters, self.events, self.now_s = Parameters(), EventLog(), 0.0
        self.watch = ComputerWatch(PERIOD_S, self.parameters, self.events.say)
        self.tick()

    def tick(self, late_s: float = 0.0, count: int = 1, faults: tuple[str, ...] = ()) -> None:
        for _ in range(count):
            self.now_s += PERIOD_S + late_s
            self.watch.update(self.now_s, faults)

    @property
    def texts(self) -> list[str]:
        return [event.text for event in self.events.drain()]


def test_one_long_stop_is_no_overload_and_neither_are_small_delays() -> None:
    computer = Watched()
    computer.tick(late_s=3.0)
    assert not computer.watch.ticks_late
    computer.tick(late_s=0.2, count=40)
    assert not computer.watch.ticks_late and computer.watch.health.ok


def test_many_late_ticks_are_an_overload_until_none_is_late_for_a_while() -> None:
    computer = Watched()
    computer.tick(late_s=0.3, count=MANY - 1)
    assert not computer.watch.ticks_late
    computer.tick(late_s=0.4)
    assert computer.watch.ticks_late
    assert not computer.watch.health.ok and computer.watch.health.text == "ticks up to 0.4 s late"
    computer.tick(count=round(WINDOW_S / PERIOD_S) - 1)
    assert computer.watch.ticks_late
    computer.tick(count=2)
    assert not computer.watch.ticks_late and computer.watch.health.ok


def test_the_bound_is_a_parameter_and_0_turns_it_off() -> None:
    computer = Watched()
    computer.parameters.set("FS_TICK_LATE", 1.0)
    computer.tick(late_s=0.6, count=20)
    assert not computer.watch.ticks_late
    computer.parameters.set("FS_TICK_LATE", 0.0)
    computer.tick(late_s=2.0, count=20)
    assert not computer.watch.ticks_late


def test_what_else_is_missing_is_announced_once_and_when_it_is_over() -> None:
    computer = Watched()
    computer.tick(count=5, faults=("little memory left",))
    computer.tick(count=5, faults=("little memory left", "few file descriptors left"))
    assert computer.watch.health.text == "little memory left; few file descriptors left"
    computer.tick(count=5)
    assert computer.texts == [
        "Computer: little memory left",
        "Computer: few file descriptors left",
        "Computer: well again",
    ]
