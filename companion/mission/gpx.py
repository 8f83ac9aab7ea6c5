"""GPX 1.0 and 1.1, as chart programs (OpenCPN, the OpenSeaMap trip planner) and receivers write it: one route, else one
track, else waypoints.

OpenCPN's planned speed of a point (in knots) applies to the leg that leads to it; that of the whole route is for
estimates only. OpenCPN's arrival radius is ignored: every file has it, usually 0.05 nautical miles, and a small boat
would cut corners by that. The extension `point` in the namespace `urn:usv-companion:route` holds what GPX cannot.
https://www.topografix.com/GPX/1/1/
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element as XmlElement

from companion.mission.markup import Element, read_xml
from companion.mission.plan_file import PlanFile, PlanFileError
from companion.mission.route import RouteFilePoint, from_plan, number, place_of, to_plan

_KNOT_MPS = 1852.0 / 3600.0
_NAMESPACE = "urn:usv-companion:route"
_LISTS = (("rte", "rtept", "route"), ("trk", "trkpt", "track"))
_OURS = (("radius_m", 0.0, 1e5), ("speed_mps", 1e-3, 1e3), ("hold_s", 0.0, math.inf), ("heading_deg", -360.0, 360.0))


def read(name: str, text: str) -> PlanFile:
    """The plan in a GPX text. Raises PlanFileError with every bad point and its line, or if there are several
    routes."""
    root = read_xml(name, text)
    if root.name != "gpx":
        raise PlanFileError([f"{root.place}: the file begins with <{root.name}>, not with <gpx>; export it as GPX"])
    return plan_of(name, root)


def plan_of(name: str, root: Element) -> PlanFile:
    """The plan in an element with routes, tracks or waypoints somewhere below it. Raises PlanFileError as `read`."""
    chosen, tag = _choose(name, root)
    problems: list[str] = []
    points: list[RouteFilePoint] = []
    for element in (found for one in chosen for found in one.all(tag)):
        point = _point(element)
        if isinstance(point, str):
            problems.append(f"{element.place}: {point}")
        else:
            points.append(point)
    if problems:
        raise PlanFileError(problems)
    plan = to_plan(name, points)
    return PlanFile(plan.mission, cruise_speed_mps=_knots(chosen[0]) if tag == "rtept" else None)


def _choose(name: str, root: Element) -> tuple[list[Element], str]:
    """The elements that hold the points, and the points' name."""
    for tag, point_tag, what in _LISTS:
        found = [element for element in root.all(tag) if element.all(point_tag)]
        if len(found) > 1:
            titles = ", ".join(
                (title.text.strip() if (title := one.child("name")) is not None else "without a name")[:30]
                for one in found[:8]
            )
            raise PlanFileError([f"{name}: {len(found)} {what}s ({titles}); export the one to sail by itself"])
        if found:
            return found, point_tag
    return [root], "wpt"


def _point(element: Element) -> RouteFilePoint | str:
    place = place_of(element.attributes.get("lat"), element.attributes.get("lon"))
    if isinstance(place, str):
        return place
    ours = next((one for one in element.walk() if one.name == "point"), None)
    values: dict[str, float] = {}
    for key, low, high in _OURS:
        if ours is not None and key in ours.attributes:
            value = number(
                ours.attributes[key],
                key,
                low,
                high,
                f"give {low:g} or more" if high > 1e4 else f"give {low:g} to {high:g}",
            )
            if isinstance(value, str):
                return value
            values[key] = value
    hold_s = values.get("hold_s", 0.0)
    speed_mps = values.get("speed_mps") or _knots(element)
    return RouteFilePoint(
        *place, values.get("radius_m"), speed_mps, None if math.isinf(hold_s) else hold_s, values.get("heading_deg")
    )


def _knots(element: Element) -> float | None:
    """OpenCPN's planned speed of a route or a point, in m/s; None if there is none."""
    extensions = element.child("extensions")
    speed = None if extensions is None else extensions.child("planned_speed")
    value = None if speed is None else number(speed.text.strip(), "speed", 0.01, 100.0, "")
    return value * _KNOT_MPS if isinstance(value, float) else None


def write(name: str, plan: PlanFile) -> str:
    """The plan as one GPX route. Raises PlanFileError with every item that is not a point of a route."""
    from gpxpy.gpx import GPX, GPXRoute, GPXRoutePoint  # imported late: it takes 60 ms

    points = from_plan(name, plan, "a GPX route")
    gpx = GPX()
    gpx.creator = "USV companion"
    gpx.nsmap = {"usv": _NAMESPACE}
    route = GPXRoute(name=name.rpartition(".")[0] or name)
    for count, point in enumerate(points, start=1):
        at = GPXRoutePoint(latitude=round(point.lat_deg, 7), longitude=round(point.lon_deg, 7), name=f"{count:03d}")
        extra = {key: repr(value).removesuffix(".0") for key, value in _extra(point).items()}
        if extra:
            at.extensions.append(XmlElement(f"{{{_NAMESPACE}}}point", extra))
        route.points.append(at)
    gpx.routes.append(route)
    return str(gpx.to_xml("1.1")) + "\n"


def _extra(point: RouteFilePoint) -> dict[str, float]:
    values = {"radius_m": point.radius_m, "speed_mps": point.speed_mps, "heading_deg": point.heading_deg}
    found = {key: value for key, value in values.items() if value is not None}
    if point.hold_s != 0.0:
        found["hold_s"] = math.inf if point.hold_s is None else point.hold_s
    return found
