"""All that is generated, by its place in the site."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from docs.generate.authority import authority
from docs.generate.command_line import command_line
from docs.generate.energy_curve import energy_curve
from docs.generate.fault_matrix import fault_matrix
from docs.generate.house import house, rooms_table
from docs.generate.hulls import hulls
from docs.generate.licences import licences
from docs.generate.log_columns import log_columns
from docs.generate.manoeuvres import manoeuvres
from docs.generate.markdown import page
from docs.generate.mavlink import mavlink_page
from docs.generate.mavsdk_examples import mavsdk_examples
from docs.generate.modes import modes
from docs.generate.parameters import parameters
from docs.generate.platforms import platforms
from docs.generate.results import results
from docs.generate.speed import growth, speed_page, speed_trend
from docs.generate.statustexts import statustexts
from docs.generate.theses import findings_page
from docs.generate.vessel_file import vessel_file
from docs.generate.wave_curve import wave_curve


def _rooms() -> str:
    return page(
        "Rooms",
        "The folders of the program, top first. [Architecture](architecture.md) says what each is for.",
        rooms_table(),
    )


PAGES: Mapping[str, Callable[[], str]] = {
    "reference/parameters.md": parameters,
    "reference/modes.md": modes,
    "reference/authority.md": authority,
    "reference/statustexts.md": statustexts,
    "reference/vessel-file.md": vessel_file,
    "reference/hulls.md": hulls,
    "reference/manoeuvres.md": manoeuvres,
    "reference/command-line.md": command_line,
    "reference/mavlink.md": mavlink_page,
    "reference/log-columns.md": log_columns,
    "reference/licences.md": licences,
    "reference/platforms.md": platforms,
    "reference/results.md": results,
    "reference/theses.md": findings_page,
    "reference/speed.md": speed_page,
    "reference/speed-trend.svg": speed_trend,
    "reference/growth.svg": growth,
    "reference/energy-curve.svg": energy_curve,
    "reference/wave-curve.svg": wave_curve,
    "reference/fault-matrix.md": fault_matrix,
    "ground-stations/mavsdk-examples.md": mavsdk_examples,
    "inside/rooms.md": _rooms,
    "inside/house.svg": house,
}


def write(folder: Path) -> None:
    """Every generated file, below `folder`."""
    for place, make in PAGES.items():
        target = folder / place
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(make(), encoding="utf-8")
