"""The track of a log for charts and globes: GPX, KML, GeoJSON. A stretch of one mode is a line of its own; events of a
warning or worse are points."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from companion.analysis.report_data import WATCHED, Array, LoggedEvent, Recorded

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_COLOURS = ("ff0000ff", "ff00a5ff", "ff00ff00", "ffff0000", "ffff00ff", "ff00ffff", "ffffffff")  # KML: alpha, b, g, r


@dataclass(frozen=True, slots=True)
class Stretch:
    """A part of the track in one mode: (n,) each; `ns` is Unix time."""

    mode: str
    lat_deg: Array
    lon_deg: Array
    speed_mps: Array
    yaw_rad: Array
    ns: Array


@dataclass(frozen=True, slots=True)
class Track:
    """All stretches, and the place of each event worth a point."""

    name: str
    stretches: Sequence[Stretch]
    events: Sequence[tuple[LoggedEvent, float, float, float]]  # event, lat_deg, lon_deg, Unix ns


def track_of(recorded: Recorded, satellites_ns: float | None = None) -> Track:
    """The track while the position was valid. `satellites_ns`: Unix time at the log's 0 s by the satellites, where that
    is to count, not the computer's clock."""
    ticks = recorded.ticks
    unix_ns = ticks["time_unix_ns"] if satellites_ns is None else satellites_ns + 1e9 * recorded.t_s
    known = np.isfinite(ticks["lat_deg"]) & (ticks["position_valid"] > 0.0)
    key = np.where(known, recorded.modes, -1)
    borders = [0, *(np.flatnonzero(np.diff(key)) + 1).tolist(), len(key)]
    speed = np.hypot(ticks["surge_mps"], ticks["sway_mps"])
    stretches = []
    for begin, end in itertools.pairwise(borders):
        if key[begin] >= 0:
            at = slice(begin, min(end + 1, len(key)) if end < len(key) and key[end] >= 0 else end)
            columns = (ticks["lat_deg"], ticks["lon_deg"], speed, ticks["yaw_rad"], unix_ns)
            stretches.append(Stretch(recorded.mode_names[key[begin]], *(column[at] for column in columns)))
    events = []
    for event in recorded.events:
        at_tick = min(int(np.searchsorted(recorded.t_s, event.t_s)), len(known) - 1)
        if event.severity in WATCHED and known[at_tick]:
            place = float(ticks["lat_deg"][at_tick]), float(ticks["lon_deg"][at_tick])
            events.append((event, *place, float(unix_ns[at_tick])))
    return Track(f"{recorded.log.config.title}: {recorded.log.folder.name}", stretches, events)


def gpx(track: Track) -> str:
    """GPX 1.1: one track, a segment for each stretch; events as waypoints."""
    from gpxpy.gpx import GPX, GPXTrack, GPXTrackPoint, GPXTrackSegment, GPXWaypoint

    out = GPX()
    out.creator = "USV companion"
    line = GPXTrack(name=track.name)
    out.tracks.append(line)
    for stretch in track.stretches:
        segment = GPXTrackSegment()
        line.segments.append(segment)
        for lat, lon, speed, ns in zip(stretch.lat_deg, stretch.lon_deg, stretch.speed_mps, stretch.ns, strict=True):
            point = GPXTrackPoint(float(lat), float(lon), time=_time(ns), speed=round(float(speed), 3))
            segment.points.append(point)
    for event, lat, lon, ns in track.events:
        out.waypoints.append(GPXWaypoint(lat, lon, time=_time(ns), name=event.text, description=event.severity))
    return str(out.to_xml("1.1")) + "\n"


def kml(track: Track) -> str:
    """KML 2.2 with a line for each stretch in its mode's colour; events as placemarks."""
    modes = list(dict.fromkeys(stretch.mode for stretch in track.stretches))
    styles = "".join(
        f'<Style id="m{n}"><LineStyle><color>{_COLOURS[n % len(_COLOURS)]}</color><width>3</width></LineStyle></Style>'
        for n, _ in enumerate(modes)
    )
    marks = []
    for stretch in track.stretches:
        points = " ".join(f"{lon:.9f},{lat:.9f}" for lat, lon in zip(stretch.lat_deg, stretch.lon_deg, strict=True))
        span = f"<TimeSpan><begin>{_iso(stretch.ns[0])}</begin><end>{_iso(stretch.ns[-1])}</end></TimeSpan>"
        marks.append(
            f"<Placemark><name>{escape(stretch.mode)}</name>{span}<styleUrl>#m{modes.index(stretch.mode)}</styleUrl>"
            f"<LineString><tessellate>1</tessellate><coordinates>{points}</coordinates></LineString></Placemark>"
        )
    for event, lat, lon, ns in track.events:
        marks.append(
            f"<Placemark><name>{escape(event.text)}</name><TimeStamp><when>{_iso(ns)}</when></TimeStamp>"
            f"<Point><coordinates>{lon:.9f},{lat:.9f}</coordinates></Point></Placemark>"
        )
    body = "\n".join((f"<name>{escape(track.name)}</name>", styles, *marks))
    head = '<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="http://www.opengis.net/kml/2.2">'
    return f"{head}<Document>\n{body}\n</Document></kml>\n"


def geojson(track: Track) -> str:
    """RFC 7946: a LineString for each stretch, a Point for each event."""
    features = list(_features(track))
    return json.dumps({"type": "FeatureCollection", "name": track.name, "features": features}, indent=1) + "\n"


def _features(track: Track) -> Iterator[Mapping[str, Any]]:
    for stretch in track.stretches:
        points = [
            [round(float(x), 9), round(float(y), 9)] for x, y in zip(stretch.lon_deg, stretch.lat_deg, strict=True)
        ]
        properties = {
            "mode": stretch.mode,
            "begin": _iso(stretch.ns[0]),
            "end": _iso(stretch.ns[-1]),
            "times": [_iso(ns) for ns in stretch.ns],
            "speed_mps": [_rounded(v, 3) for v in stretch.speed_mps],
            "heading_deg": [_rounded(math.degrees(v) % 360.0, 2) for v in stretch.yaw_rad],
        }
        shape = {"type": "LineString", "coordinates": points if len(points) > 1 else points * 2}
        yield {"type": "Feature", "geometry": shape, "properties": properties}
    for event, lat, lon, ns in track.events:
        said = {"text": event.text, "severity": event.severity, "name": event.name, "time": _iso(ns)}
        point = {"type": "Point", "coordinates": [round(lon, 9), round(lat, 9)]}
        yield {"type": "Feature", "geometry": point, "properties": said}


FORMATS: Mapping[str, Callable[[Track], str]] = {"gpx": gpx, "kml": kml, "geojson": geojson}


def _time(ns: float) -> datetime:
    return _EPOCH + timedelta(microseconds=int(ns) // 1000)


def _iso(ns: float) -> str:
    return _time(ns).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _rounded(value: float, digits: int) -> float | None:
    return round(float(value), digits) if math.isfinite(value) else None
