"""A distress beacon that a receiver hears, as the boat announces it."""

from __future__ import annotations

from typing import Any

from companion.core.readings import AisTarget


def test_the_boat_announces_a_beacon_once(boat: Any) -> None:
    boat.tick()
    nav = boat.supervisor.parts.nav
    for _ in range(30):
        beacon = AisTarget(boat.now_s, "ais", 972123456, nav.lat_deg + 0.01, nav.lon_deg, status=14)
        boat.supervisor.traffic_heard(beacon, boat.now_s)
        boat.tick()
    told = [text for text in boat.texts() if text.startswith("Distress: MOB 972123456, 11")]
    assert len(told) == 1 and told[0].endswith(" m at 000 deg")
