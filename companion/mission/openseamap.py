"""Routes of the OpenSeaMap trip planner, and the JSON that a converter makes from them (as in the ÅBOAT project).

The planner saves a drawn line as GML 2 or KML, in one text of `longitude,latitude` pairs (`gml:coordinates`,
`coordinates`), or as a GPX track (javascript/NauticalRoute.js in github.com/OpenSeaMap/online_chart). `.xml` may be any
of the three.

The format of ÅBOAT's converter is not published, so `.json` may have several forms: the names of the XML as keys, with
attributes in any of the usual spellings (see `markup.from_json`); or a plain list of points, by itself or under
`waypoints`, `points`, `route` or `coordinates`. A point has `lat` and `lon` (or `latitude`, `longitude`, `lng`), and
optionally `tolerance_m` (or `radius_m`), `speed_mps`, `hold_s` ("forever" to stay) and `heading_deg`. `write_json`
writes `{"waypoints": [{"lat": …, "lon": …, …}]}`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any
from xml.sax.saxutils import escape

from companion.mission import gpx
from companion.mission.markup import Element, from_json, read_json, read_xml
from companion.mission.plan_file import PlanFile, PlanFileError
from companion.mission.route import RouteFilePoint, from_plan, number, place_of, to_plan

_LISTS = ("waypoints", "points", "route", "coordinates")
_LAT, _LON = ("lat", "latitude"), ("lon", "lng", "longitude")
_TOLERANCE = ("tolerance_m", "radius_m", "tolerance", "radius")
_FOREVER = "forever"
_GML = """<?xml version="1.0" encoding="UTF-8"?>
<gml:featureMember xmlns:gml="http://www.opengis.net/gml"><gml:LineString>\
<gml:coordinates decimal="." cs="," ts=" ">{}</gml:coordinates>\
</gml:LineString></gml:featureMember>
"""
_KML = """<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><name>{}</name><LineString><coordinates>{}</coordinates></LineString>\
</Placemark></Document></kml>
"""


def read_markup(name: str, text: str) -> PlanFile:
    """The plan in a GML, KML or GPX text, whatever the suffix. Raises PlanFileError with line and coordinate pair."""
    return _plan_of(name, read_xml(name, text))


def write_gml(name: str, plan: PlanFile) -> str:
    """The plan as the planner's GML. Raises PlanFileError for everything but positions."""
    return _GML.format(_pairs(from_plan(name, plan, "a GML route", plain=True)))


def write_kml(name: str, plan: PlanFile) -> str:
    """The plan as one KML line. Raises PlanFileError for everything but positions."""
    return _KML.format(escape(name.rpartition(".")[0]), _pairs(from_plan(name, plan, "a KML route", plain=True)))


def _pairs(points: tuple[RouteFilePoint, ...]) -> str:
    return " ".join(f"{point.lon_deg:.7f},{point.lat_deg:.7f}" for point in points)


def _plan_of(name: str, root: Element) -> PlanFile:
    if root.all("rte") or root.all("trk") or root.all("wpt"):
        return gpx.plan_of(name, root)
    lines = [line for line in root.all("coordinates") if line.text.strip()]
    if not lines:
        raise PlanFileError(
            [f"{root.place}: no route in it: neither GPX nor <coordinates> of GML or KML; download the route as GPX"]
        )
    several = [line for line in lines if len(line.text.split()) > 1]
    if len(several) > 1:
        raise PlanFileError(
            [f"{name}: {len(several)} lines ({', '.join(line.place for line in several[:8])}); keep the one to sail"]
        )
    problems: list[str] = []
    points: list[RouteFilePoint] = []
    for line in several or lines:
        for count, pair in enumerate(re.sub(r"\s*,\s*", ",", line.text).split()):
            lon, _, rest = pair.partition(",")
            place = place_of(rest.partition(",")[0] or None, lon or None)
            if isinstance(place, str):
                problems.append(f"{line.place}: pair {count} ({pair[:40]}): {place}")
            else:
                points.append(RouteFilePoint(*place))
    if problems:
        raise PlanFileError(problems)
    return to_plan(name, points)


# --- JSON ----------------------------------------------------------------------------------------------------------


def read_json_route(name: str, text: str) -> PlanFile:
    """The plan in a JSON text. Raises PlanFileError with every bad point and its path in the file."""
    content = read_json(name, text)
    way, points = _list_of(content)
    if points is not None:
        problems: list[str] = []
        read = [_json_point(f"{name}: {way}[{count}]", point, problems) for count, point in enumerate(points)]
        if problems:
            raise PlanFileError(problems)
        return to_plan(name, [point for point in read if point is not None])
    if not isinstance(content, Mapping):
        raise PlanFileError([f"{name}: no route in it; give a list of points with lat and lon"])
    return _plan_of(name, from_json(name, content))


def _list_of(content: Any) -> tuple[str, list[Any] | None]:
    """(key, plain list of points); ("", None) if the content has another form."""
    if isinstance(content, list):
        return "", content
    for key in _LISTS if isinstance(content, Mapping) else ():
        if isinstance(content.get(key), list):
            return key, content[key]
    return "", None


def _json_point(place: str, raw: Any, problems: list[str]) -> RouteFilePoint | None:
    if not isinstance(raw, Mapping):
        problems.append(f"{place}: not an object; give lat and lon")
        return None
    wrong: list[str] = []
    at = place_of(_first(raw, _LAT), _first(raw, _LON))
    if isinstance(at, str):
        wrong.append(at)
    stays_for_ever = raw.get("hold_s") == _FOREVER
    hold = None if stays_for_ever else _value(raw, ("hold_s",), 0.0, 1e9, wrong)
    radius = _value(raw, _TOLERANCE, 0.0, 1e5, wrong)
    speed = _value(raw, ("speed_mps", "speed"), 1e-3, 1e3, wrong)
    heading = _value(raw, ("heading_deg",), -360.0, 360.0, wrong)
    problems.extend(f"{place}: {text}" for text in wrong)
    if wrong or isinstance(at, str):
        return None
    return RouteFilePoint(*at, radius or None, speed, None if stays_for_ever else hold or 0.0, heading)


def _first(raw: Mapping[str, Any], keys: tuple[str, ...]) -> str | None:
    """The first value among `keys` as text, or None. One that is not a number stays as it is, for the message."""
    value = next((raw[key] for key in keys if raw.get(key) is not None), None)
    return None if value is None or isinstance(value, bool) else str(value)


def _value(raw: Mapping[str, Any], keys: tuple[str, ...], low: float, high: float, wrong: list[str]) -> float | None:
    """The first number among `keys`; None if there is none, or, with a text in `wrong`, if it is invalid."""
    text = _first(raw, keys)
    if text is None:
        return None
    value = number(text, keys[0], low, high, f"give {low:g} to {high:g}, or leave it out")
    if isinstance(value, str):
        wrong.append(value)
        return None
    return value


def write_json(name: str, plan: PlanFile) -> str:
    """The plan as a JSON list of points. Raises PlanFileError with every item that is not a point of a route."""
    points = from_plan(name, plan, "a JSON route")
    lines = ",\n".join(f"    {json.dumps(_members(point))}" for point in points)
    return f'{{\n  "waypoints": [\n{lines}\n  ]\n}}\n'


def _members(point: RouteFilePoint) -> dict[str, float | str]:
    members: dict[str, float | str | None] = {
        "lat": round(point.lat_deg, 7),
        "lon": round(point.lon_deg, 7),
        "tolerance_m": point.radius_m,
    }
    members |= {"speed_mps": point.speed_mps, "heading_deg": point.heading_deg}
    if point.hold_s != 0.0:
        members["hold_s"] = _FOREVER if point.hold_s is None else point.hold_s
    return {key: value for key, value in members.items() if value is not None}
