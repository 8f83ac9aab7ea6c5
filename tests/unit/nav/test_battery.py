"""Which device's battery counts, and how full it is."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config import vessel as vessel_config
from companion.config.outputs import BatteryConfig
from companion.core.decision import Severity
from companion.core.readings import Battery
from companion.nav.battery import BatteryGauge
from companion.params.store import Parameters

REVOLT = vessel_config.load(vessel_config.find("revolt"))
TWO = replace(REVOLT, actuators=(replace(REVOLT.actuators[0], name="fore"), replace(REVOLT.actuators[0], name="aft")))


class Bench:
    def __init__(self, battery: BatteryConfig | None = None, **parameters: float) -> None:
        self.said: list[str] = []
        self.parameters = Parameters(parameters)
        self.gauge = BatteryGauge(replace(TWO, battery=battery), self.parameters, self.say)
        self.now: Battery | None = None
        self.t_s = 0.0

    def say(self, t_s: float, severity: Severity, name: str, text: str) -> None:
        self.said.append(text)

    def hear(self, source: str, voltage_v: float, remaining: float | None = None) -> Battery | None:
        self.t_s += 1.0
        self.now = self.gauge.update(Battery(self.t_s, source, voltage_v, None, remaining), self.now, self.t_s)
        return self.now


def test_by_default_the_newest_of_any_device_counts() -> None:
    bench = Bench()
    assert [bench.hear(source, 12.0).source for source in ("aft", "fore", "anything")] == ["aft", "fore", "anything"]


def test_one_bridge_is_chosen() -> None:
    bench = Bench(BAT1_SOURCE=2)
    assert bench.hear("fore", 12.0) is None
    assert bench.hear("aft", 11.0) == Battery(2.0, "aft", 11.0, None, None)
    assert bench.hear("fore", 12.0) == Battery(2.0, "aft", 11.0, None, None), "the other changes nothing"
    bench.parameters.set("BAT1_SOURCE", -1)
    assert bench.hear("aft", 11.0) is None
    assert bench.said == []


def test_a_bridge_that_is_not_there_is_announced_once() -> None:
    bench = Bench(BAT1_SOURCE=3)
    assert bench.hear("fore", 12.0) is None and bench.hear("aft", 12.0) is None
    assert bench.said == ["No battery: BAT1_SOURCE is 3, bridges are 2"]


def test_voltage_tells_the_charge_where_nothing_else_does() -> None:
    cells = {"BAT1_N_CELLS": 3.0, "BAT1_V_EMPTY": 3.5, "BAT1_V_CHARGED": 4.0}
    shares = [Bench(**cells).hear("fore", volts).remaining for volts in (9.0, 10.5, 11.25, 12.0, 13.0)]
    assert shares == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0])
    bench = Bench(**cells)
    assert bench.hear("fore", 11.25).remaining == pytest.approx(0.5)
    assert bench.hear("fore", 9.0).remaining == pytest.approx(0.36, abs=0.01), "a pull of the thrusters is not the end"
    for _ in range(60):
        bench.hear("fore", 9.75)
    assert bench.now is not None and bench.now.remaining == pytest.approx(0.0, abs=0.01)
    assert bench.hear("fore", math.nan).remaining is None
    assert bench.hear("fore", 11.25, 0.9).remaining == 0.9, "the device knows"
    bench.parameters.set("BAT1_V_EMPTY", 4.5)
    assert bench.hear("fore", 11.25).remaining is None
    counted = Bench(BatteryConfig(10.0, 12.0, 10.0), BAT1_N_CELLS=3)
    full = counted.gauge.update(Battery(0.0, "fore", 12.0, 1.0, None), None, 0.0)
    assert full is not None and full.remaining == 1.0, "the vessel file counts"


def test_of_several_packs_the_emptiest_counts_until_it_is_no_longer_heard() -> None:
    bench = Bench()
    heard = [bench.hear(name, 12.0, left) for name, left in (("fore", 0.8), ("aft", 0.3), ("fore", 0.79))]
    assert [battery.remaining for battery in heard if battery is not None] == [0.8, 0.3, 0.3]
    for left in (0.78, 0.77):
        bench.t_s += 6.0
        last = bench.hear("fore", 12.0, left)
    assert last is not None and (last.source, last.remaining) == ("fore", 0.77)


def test_a_pack_of_unknown_charge_does_not_hide_one_that_is_nearly_empty() -> None:
    bench = Bench()
    heard = [bench.hear(name, 12.0, left) for name, left in (("service", None), ("motor", 0.05), ("service", None))]
    assert [battery.remaining for battery in heard if battery is not None] == [None, 0.05, 0.05]


def test_a_pack_that_does_not_count_is_not_the_emptiest() -> None:
    bench = Bench()
    bench.hear("aft", 12.0, 0.1)
    bench.parameters.set("BAT1_SOURCE", 1)
    last = bench.hear("fore", 12.0, 0.9)
    assert last is not None and last.source == "fore"


def test_every_pack_is_told_in_the_order_of_the_bridges() -> None:
    bench = Bench(BAT1_SOURCE=1)
    for name, volts in (("house", 12.0), ("aft", 24.0), ("fore", 25.0)):
        bench.hear(name, volts)
    packs = bench.gauge.packs(bench.t_s)
    assert [pack.source for pack in packs if pack is not None] == ["fore", "aft", "house"], "also what does not count"
    bench.t_s += 9.0
    bench.hear("fore", 25.0)
    late = bench.gauge.packs(bench.t_s)
    assert [None if pack is None else pack.source for pack in late] == ["fore", None, None]
    bench.parameters.set("BAT1_SOURCE", -1)
    assert bench.gauge.packs(bench.t_s) == ()
