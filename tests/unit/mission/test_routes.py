"""Routes of chart programs: what OpenCPN, the OpenSeaMap trip planner and converters write, read back, written again
and refused."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import gpxpy
import pytest

from companion.core.geodesy import LocalFrame
from companion.mission import files
from companion.mission.commands import DESTINATIONS
from companion.mission.markup import MOST_ELEMENTS
from companion.mission.plan import PlanItem, PlanKind
from companion.mission.validation import check_item, check_plan

TURKU = ((60.43, 22.16), (60.4312345, 22.1612345), (60.4325, 22.165))

# As OpenCPN 5 exports a route.
OPENCPN = """<?xml version="1.0"?>
<gpx version="1.1" creator="OpenCPN" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns="http://www.topografix.com/GPX/1/1"
     xmlns:gpxx="http://www.garmin.com/xmlschemas/GpxExtensions/v3" xmlns:opencpn="http://www.opencpn.org">
  <rte>
    <name>Ruissalo</name>
    <extensions>
      <opencpn:start>A</opencpn:start>
      <opencpn:planned_speed>5.00</opencpn:planned_speed>
      <gpxx:RouteExtension><gpxx:IsAutoNamed>false</gpxx:IsAutoNamed></gpxx:RouteExtension>
    </extensions>
    <rtept lat="60.430000000" lon="22.160000000">
      <time>2026-05-01T10:00:00Z</time><name>001</name><sym>diamond</sym><type>WPT</type>
      <extensions><opencpn:arrival_radius>0.050</opencpn:arrival_radius></extensions>
    </rtept>
    <rtept lat="60.431234500" lon="22.161234500">
      <name>002 &amp; a bit</name>
      <extensions><opencpn:planned_speed>3.0</opencpn:planned_speed></extensions>
    </rtept>
    <rtept lat="60.4325" lon="22.165"/>
  </rte>
</gpx>
"""
# As OpenLayers writes the trip planner's line.
TRACK = """<gpx xmlns="http://www.topografix.com/GPX/1/1" version="1.1" creator="OpenLayers"><trk><name>OpenLayers_Feature_1</name>\
<desc>No description available</desc><trkseg><trkpt lon="22.16" lat="60.43"/><trkpt lon="22.1612345" lat="60.4312345"/>\
<trkpt lon="22.165" lat="60.4325"/></trkseg></trk></gpx>"""
PAIRS = "22.16,60.43 22.1612345,60.4312345 22.165,60.4325"
GML = f"""
<gml:featureMember xmlns:gml="http://www.opengis.net/gml">
    <gml:null><gml:geometry><gml:LineString>
        <gml:coordinates decimal="." cs="," ts=" ">{PAIRS} </gml:coordinates>
    </gml:LineString></gml:geometry></gml:null>
</gml:featureMember>
"""
KML = f"""<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://earth.google.com/kml/2.0">
<Folder>
<name>OpenSeaMap Route</name><description>test</description><Placemark><name>OpenSeaMap</name><LineString>
<coordinates>
{PAIRS}
</coordinates>
</LineString>
</Placemark>
</Folder>
</kml>"""


def points(plan: files.PlanFile) -> list[tuple[float, float]]:
    return [(item.x / 1e7, item.y / 1e7) for item in plan.mission if item.command in DESTINATIONS]


def exactly(plan: files.PlanFile) -> str:
    return repr([replace(item, command=int(item.command)) for item in plan.mission])


def converted(xml: str, attributes: str) -> str:
    """GPX by way of a converter with that habit."""
    gpx = gpxpy.parse(xml)
    path = [{"lat": str(p.latitude), "lon": str(p.longitude)} for p in gpx.tracks[0].segments[0].points]
    as_one = [
        {attributes: p} if attributes in ("$", "_attributes") else {f"{attributes}{k}": v for k, v in p.items()}
        for p in path
    ]
    return json.dumps({"gpx": {"@version": "1.1", "trk": {"name": {"#text": "x"}, "trkseg": {"trkpt": as_one}}}})


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("route.gpx", OPENCPN),
        ("route.gpx", TRACK),
        ("route.gpx", "\ufeff" + TRACK),
        ("route.xml", TRACK),
        ("route.xml", GML),
        ("route.gml", GML),
        ("route.kml", KML),
        ("route.xml", KML),
        *(("route.json", converted(TRACK, habit)) for habit in ("@", "-", "_", "", "$", "_attributes")),
        (
            "route.json",
            json.dumps({"gml:featureMember": {"gml:LineString": {"gml:coordinates": {"@cs": ",", "#text": PAIRS}}}}),
        ),
        ("route.json", json.dumps({"kml": {"Folder": [{"Placemark": [{"LineString": [{"coordinates": [PAIRS]}]}]}]}})),
        ("route.json", json.dumps([{"lat": lat, "lon": lon} for lat, lon in TURKU])),
        ("route.json", json.dumps({"route": [{"latitude": str(lat), "lng": lon} for lat, lon in TURKU]})),
    ],
)
def test_a_route_is_read(name: str, text: str) -> None:
    plan = files.read(name, text)
    assert points(plan) == [pytest.approx(point, abs=1e-9) for point in TURKU]
    assert [refusal for item in plan.mission if (refusal := check_item(PlanKind.MISSION, item))] == []
    assert check_plan(PlanKind.MISSION, plan.mission) is None


def test_speeds_are_of_the_leg_to_the_point_and_opencpns_radius_is_ignored() -> None:
    plan = files.read("a.gpx", OPENCPN)
    assert [item.command for item in plan.mission] == [16, 178, 16, 178, 16]
    assert plan.mission[1].param2 == pytest.approx(3.0 * 0.514444, rel=1e-5)
    assert plan.mission[3].param2 == -2.0
    assert plan.cruise_speed_mps == pytest.approx(5.0 * 0.514444, rel=1e-5)
    assert {item.param2 for item in plan.mission if item.command == 16} == {0.0}


def test_tolerances_speeds_and_stays_of_json() -> None:
    text = '{"waypoints": [{"lat": 60, "lon": 22, "tolerance": 5, "speed": 1.5}, {"lat": 60.1, "lon": 22, "speed": 1.5, "hold_s": 9, "heading_deg": 0},'
    plan = files.read("r.json", text + '{"lat": 60.2, "lon": 22, "hold_s": "forever"}]}')
    assert [item.command for item in plan.mission] == [178, 16, 16, 178, 17]
    assert (plan.mission[1].param2, plan.mission[2].param1, plan.mission[2].param4) == (5.0, 9.0, 360.0)


FULL = (
    PlanItem(0, 178, 2, 1.0, 0.4000000059604645, -1.0, 0.0, 0, 0, 0.0),
    PlanItem(1, 16, 3, 0.0, 2.5, 0.0, math.nan, 634389000, 103990000, 0.0),
    PlanItem(2, 16, 3, 12.0, 0.0, 0.0, 90.0, 634389001, -1799999999, 0.0),
    PlanItem(3, 178, 2, 1.0, -2.0, -1.0, 0.0, 0, 0, 0.0),
    PlanItem(4, 17, 3, 0.0, 0.0, 0.0, math.nan, -900000000, 0, 0.0),
)


@pytest.mark.parametrize("name", ["a.gpx", "a.json"])
def test_the_content_of_a_route_comes_back_exactly(name: str) -> None:
    assert exactly(files.read(name, files.write(name, files.PlanFile(FULL)))) == exactly(files.PlanFile(FULL))


@pytest.mark.parametrize("name", ["a.gml", "a.xml", "a.kml", "a.gpx", "a.json"])
def test_positions_come_back_exactly(name: str) -> None:
    plan = files.read("a.xml", GML)
    assert exactly(files.read(name, files.write(name, plan))) == exactly(plan)


def test_gpx_is_what_an_independent_reader_reads() -> None:
    gpx = gpxpy.parse(files.write("a.gpx", files.PlanFile(FULL)))
    (route,) = gpx.routes
    assert gpx.version == "1.1"
    assert [(p.latitude, p.longitude) for p in route.points] == [
        (63.4389, 10.399),
        (63.4389001, -179.9999999),
        (-90.0, 0.0),
    ]


def test_what_a_route_cannot_hold_is_refused_item_by_item() -> None:
    frame = LocalFrame(63.4389, 10.399)
    waypoint = PlanItem(0, 16, 3, 5.0, 0.0, 0.0, math.nan, *(round(v * 1e7) for v in frame.to_geodetic(5.0, 5.0)), 0.0)
    items = (
        waypoint,
        PlanItem(1, 177, 2, 0.0, 1.0, 0.0, 0.0, 0, 0, 0.0),
        PlanItem(2, 206, 2, 1.0, 0.0, 0.0, 0.0, 0, 0, 0.0),
    )
    rally = (PlanItem(0, 5100, 3, 0.0, 0.0, 0.0, 0.0, 634389000, 103990000, 0.0),)
    with pytest.raises(files.PlanFileError) as caught:
        files.write("a.gpx", files.PlanFile(items, rally=rally))
    assert caught.value.problems == [
        "a.gpx: the list of rally points has no place in a GPX route; write a .plan file",
        "a.gpx: item 2: DO_JUMP has no place in a GPX route; write a .plan file",
    ]
    with pytest.raises(
        files.PlanFileError, match="item 1: its radius, speed, stay or heading has no place in a KML route"
    ):
        files.write("a.kml", files.PlanFile((waypoint,)))


BOMB = '<!DOCTYPE lolz [<!ENTITY a "lol"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;">]><gpx><wpt lat="1" lon="1"><name>&b;</name></wpt></gpx>'
OUTSIDE = '<!DOCTYPE gpx [<!ENTITY secret SYSTEM "file:///etc/passwd">]><gpx><wpt lat="1" lon="1"><name>&secret;</name></wpt></gpx>'
REMOTE = '<!DOCTYPE gpx SYSTEM "http://127.0.0.1:9/x.dtd"><gpx><wpt lat="1" lon="1"/></gpx>'


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("a.gpx", BOMB, "a.gpx: it declares a document type or entities"),
        ("a.kml", OUTSIDE, "declares a document type"),
        ("a.xml", REMOTE, "declares a document type"),
        ("a.gpx", OPENCPN[:300], "a.gpx:6: not well-formed XML"),
        ("a.gpx", "", "not well-formed XML"),
        ("a.gpx", "<gpx/>", "no points in it"),
        ("a.gpx", KML, "a.gpx:2: the file begins with <kml>, not with <gpx>"),
        ("a.gpx", OPENCPN.replace('lat="60.431234500" ', ""), "a.gpx:15: no latitude; give −90 to 90 degrees"),
        ("a.gpx", OPENCPN.replace("22.165", "222.165"), "a.gpx:19: longitude is 222.165"),
        ("a.gpx", OPENCPN.replace("60.4325", "nan"), "latitude is nan"),
        (
            "a.gpx",
            OPENCPN.replace("</gpx>", "<rte><name>B</name><rtept lat='1' lon='1'/></rte></gpx>"),
            r"2 routes \(Ruissalo, B\); export the one",
        ),
        ("a.gpx", f"<gpx>{'<wpt/>' * (MOST_ELEMENTS + 1)}</gpx>", f"more than {MOST_ELEMENTS} elements"),
        ("a.gpx", "<gpx>" * 100, "nested deeper"),
        ("a.xml", "<a/>", "a.xml:1: no route in it"),
        ("a.gml", GML.replace("22.165,60.4325", "22.165;60.4325"), r"a.gml:4: pair 2 \(22.165;60.4325\)"),
        (
            "a.kml",
            KML.replace("</kml>", f"<coordinates>{PAIRS}</coordinates></kml>"),
            r"2 lines \(a.kml:5, a.kml:11\); keep the one",
        ),
        ("a.json", "{", "a.json:1:2: "),
        ("a.json", "7", "no route in it"),
        ("a.json", "[]", "no points in it"),
        ("a.json", "[" * 100_000, "a.json: "),
        ("a.json", '{"a":' * 500 + "{}" + "}" * 500, "nested deeper"),
        (
            "a.json",
            '{"waypoints": [{"lat": 1, "lon": 2}, {"lat": true, "lon": 2}]}',
            r"a.json: waypoints\[1\]: no latitude",
        ),
        ("a.json", '[{"lat": 1, "lon": 2, "speed_mps": -1}]', r"\[0\]: speed_mps is -1; give 0.001 to 1000"),
        (
            "a.json",
            '{"gpx": {"rte": {"rtept": [{"@lat": 1, "@lon": 2}, {"@lat": 1}]}}}',
            r"gpx.rte.rtept\[1\]: no longitude",
        ),
        ("a.json", '[{"lat": NaN, "lon": 2}]', "NaN is no JSON"),
    ],
)
def test_each_problem_is_reported_with_its_place(name: str, text: str, problem: str) -> None:
    with pytest.raises(files.PlanFileError, match=problem):
        files.read(name, text)


def test_a_huge_file_is_refused_before_it_is_read() -> None:
    with pytest.raises(files.PlanFileError, match="16000001 characters"):
        files.read("a.plan", " " * (files.LONGEST_TEXT + 1))
