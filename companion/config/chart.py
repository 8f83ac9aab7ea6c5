"""Charts of known obstacles: GeoJSON files in WGS 84 (RFC 7946) that a vessel's file names.

A feature's property `kind` says what it is; without one, `OBJL`, the number of its object class in S-57, as GDAL writes
it; without that, `kind` of the `[[chart]]`. Source: IHO S-57, Appendix A, Object Catalogue.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from pydantic import Field

from companion.config.fields import STRICT, means
from companion.core.nearest import did_you_mean

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

Kind = Literal["land", "quay", "pile", "buoy", "depth", "rock", "wreck", "obstruction"]

_KINDS: tuple[str, ...] = get_args(Kind)
_SUNKEN = ("depth", "rock", "wreck", "obstruction")  # kinds that count by their depth
_MOST_BYTES, _MOST_CORNERS, _MOST_PROBLEMS = 20_000_000, 20_000, 10
_RADIUS_M = {"Point": 2.0, "MultiPoint": 2.0, "LineString": 0.5, "MultiLineString": 0.5}  # of a feature without its own
_MOST_RADIUS_M = 1000.0
_WGS_84 = ("CRS84", "EPSG::4326", "EPSG:4326")
_DEPTHS = ("depth_m", "DRVAL1", "VALSOU")
_OBJL: Mapping[int, str] = {
    **dict.fromkeys((5, 6, 7, 8, 9, 84, 90, 98), "pile"),  # BCN…, MORFAC, PILPNT, PYLONS
    **dict.fromkeys((14, 15, 16, 17, 18, 19), "buoy"),  # BOY…
    **dict.fromkeys((26, 38, 47, 49, 57, 61, 65, 87, 95, 122), "quay"),
    # CAUSWY, DAMCON, DRYDOC, DYKCON, FLODOC, GATCON, HULKES, OFSPLF, PONTON, SLCONS
    **dict.fromkeys((42, 46), "depth"),  # DEPARE, DRGARE
    **dict.fromkeys((55, 82, 86), "obstruction"),  # FSHFAC, MARCUL, OBSTRN
    71: "land",
    153: "rock",
    159: "wreck",
}


@dataclass(frozen=True, slots=True)
class ChartConfig:
    """Known obstacles from a file. Ways keep CP_DIST from them."""

    __pydantic_config__ = STRICT
    file: Annotated[
        str, Field(min_length=1), means("GeoJSON file in WGS 84; a relative path counts from the vessel's file.")
    ]
    kind: Annotated[
        Kind | None,
        means("What its features are that do not say it themselves, by `kind` or by S-57's `OBJL`."),
    ] = None


@dataclass(frozen=True, slots=True)
class ChartFeature:
    """One thing in a chart. `geometry`: a shapely geometry of longitude and latitude in degrees. `depth_m`: least water
    over it at chart datum, None where unknown. `radius_m`: how far it reaches beyond the geometry."""

    kind: str
    geometry: BaseGeometry
    radius_m: float
    depth_m: float | None = None

    def is_obstacle(self, least_m: float) -> bool:
        """Whether a boat keeps clear of it that needs `least_m` of water; 0 where it does not mind the depth.

        What rises from the bottom is an obstacle unless the water over it is known to be enough.
        """
        if self.kind not in _SUNKEN:
            return True
        if self.kind == "depth":
            drying = self.depth_m is not None and self.depth_m < 0.0
            return drying or (least_m > 0.0 and (self.depth_m is None or self.depth_m < least_m))
        return least_m <= 0.0 or self.depth_m is None or self.depth_m < least_m


class ChartError(Exception):
    """A chart that cannot be used. `problems`: one line for each fault, with file, feature and remedy."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


def placed_charts(charts: Sequence[ChartConfig], folder: Path) -> tuple[ChartConfig, ...]:
    """Charts with the paths of their files from the folder of the vessel's file."""
    return tuple(replace(chart, file=str(folder / chart.file)) for chart in charts)


def read_charts(charts: Sequence[ChartConfig]) -> tuple[ChartFeature, ...]:
    """All features of the charts. Raises ChartError with what is wrong in any of them."""
    found: list[ChartFeature] = []
    problems: list[str] = []
    for chart in charts:
        try:
            found += read_chart(Path(chart.file), chart.kind)
        except ChartError as error:
            problems += error.problems
    if not problems and (count := sum(_corners(one.geometry) for one in found)) > _MOST_CORNERS:
        problems.append(_too_many(", ".join(chart.file for chart in charts), count))
    if problems:
        raise ChartError(problems)
    return tuple(found)


def read_chart(file: Path, kind: str | None) -> list[ChartFeature]:
    """The features of one file; `kind`: of those that do not tell it. Raises ChartError."""
    try:
        if file.stat().st_size > _MOST_BYTES:
            text = f"larger than {_MOST_BYTES // 1_000_000} MB; cut it to the waters of the boat (ogr2ogr -clipsrc)"
            raise ChartError([f"{file}: {text}"])
        return parse_chart(file.read_bytes(), str(file), kind)
    except OSError as error:
        raise ChartError([f"{file}: cannot be read: {error.strerror}"]) from error


def parse_chart(content: bytes, place: str, kind: str | None) -> list[ChartFeature]:
    """As `read_chart`, for bytes already in hand; `place` names them in messages."""
    found: list[ChartFeature] = []
    problems: list[str] = []
    for number, row in enumerate(_rows(content, place), 1):
        try:
            found += _features(row, kind)
        except ValueError as error:
            problems.append(f"{place}: feature {number}{_label(row)}: {error}")
    if len(problems) > _MOST_PROBLEMS:
        problems[_MOST_PROBLEMS:] = [f"{place}: {len(problems) - _MOST_PROBLEMS} more features are wrong"]
    if not problems and (count := sum(_corners(one.geometry) for one in found)) > _MOST_CORNERS:
        problems.append(_too_many(place, count))
    if problems:
        raise ChartError(problems)
    return found


def _rows(content: bytes, place: str) -> list[Any]:
    """The features as they stand in the file. Raises ChartError."""
    try:
        data = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise ChartError([f"{place}: not valid JSON: {error}"]) from error
    rows = data.get("features") if isinstance(data, dict) and data.get("type") == "FeatureCollection" else None
    if not isinstance(rows, list):
        raise ChartError([f"{place}: no FeatureCollection of GeoJSON; write it with ogr2ogr -f GeoJSON"])
    if (crs := _other_crs(data)) is not None:
        raise ChartError([f"{place}: is in {crs}; write it in WGS 84 (ogr2ogr -t_srs EPSG:4326)"])
    return rows


def _too_many(place: str, count: int) -> str:
    remedy = "cut it to the waters of the boat (ogr2ogr -clipsrc), or simplify it (ogr2ogr -simplify 0.00001)"
    return f"{place}: {count} corners, room for {_MOST_CORNERS}; {remedy}"


def _other_crs(data: Mapping[str, Any]) -> str | None:
    """Name of a coordinate system that is not WGS 84 in degrees; None where it is."""
    crs = data.get("crs")
    properties = crs.get("properties") if isinstance(crs, dict) else None
    name = properties.get("name") if isinstance(properties, dict) else None
    return None if name is None or str(name).endswith(_WGS_84) else str(name)


def _label(row: Any) -> str:
    """What the feature is called, for messages."""
    properties = row.get("properties") if isinstance(row, dict) else None
    name = None if not isinstance(properties, dict) else properties.get("name") or properties.get("OBJNAM")
    return f" ({str(name)[:40]})" if name else ""


def _features(row: Any, default: str | None) -> Iterator[ChartFeature]:
    """The feature of a row; none for one without a geometry, or of an S-57 class that is no obstacle. Raises
    ValueError."""
    if not isinstance(row, dict) or row.get("type") != "Feature":
        raise ValueError("is no Feature; remove it")
    properties = row.get("properties") or {}
    if not isinstance(properties, dict):
        raise ValueError("its properties are no object; remove them")
    if row.get("geometry") is None:
        return
    kind = _kind(properties, default)
    if kind is None:
        return
    geometry = _geometry(row["geometry"])
    radius_m = _number(properties, ("radius_m",), lambda value: 0.0 <= value <= _MOST_RADIUS_M, "0 to 1000")
    depth_m = _number(properties, _DEPTHS, lambda value: abs(value) <= 12_000.0, "metres, positive below datum")
    yield ChartFeature(
        kind, geometry, _RADIUS_M.get(geometry.geom_type, 0.0) if radius_m is None else radius_m, depth_m
    )


def _kind(properties: Mapping[str, Any], default: str | None) -> str | None:
    """None for an S-57 class that is no obstacle."""
    kind = properties.get("kind")
    if kind is None and isinstance(properties.get("OBJL"), int):
        return _OBJL.get(properties["OBJL"])
    kind = default if kind is None else kind
    if kind is None:
        raise ValueError("has no kind; give it a property 'kind', or its [[chart]] a key 'kind'")
    if kind not in _KINDS:
        raise ValueError(f"kind '{kind}' is not known; use {', '.join(_KINDS)}{did_you_mean(str(kind), _KINDS)}")
    return str(kind)


def _number(
    properties: Mapping[str, Any], names: Sequence[str], allowed: Callable[[float], bool], asked: str
) -> float | None:
    """The first of these properties that is there; None without one."""
    for name in names:
        value = properties.get(name)
        if value is None:
            continue
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise ValueError(f"{name} is '{value}'; give a number: {asked}")
        if not allowed(float(value)):
            raise ValueError(f"{name} is {value:g}; give {asked}")
        return float(value)
    return None


def _geometry(given: Any) -> BaseGeometry:
    """The geometry in two dimensions. Raises ValueError."""
    import shapely
    from shapely.geometry import shape

    try:
        geometry: BaseGeometry = shapely.force_2d(shape(given))
    except Exception as error:
        raise ValueError(f"its geometry cannot be read ({error}); draw it again") from error
    if geometry.is_empty:
        raise ValueError("its geometry is empty; remove it")
    west, south, east, north = geometry.bounds
    if not (-180.0 <= west <= east <= 180.0 and -90.0 <= south <= north <= 90.0):
        raise ValueError("lies outside longitude ±180, latitude ±90; write it in WGS 84 (ogr2ogr -t_srs EPSG:4326)")
    return geometry


def _corners(geometry: BaseGeometry) -> int:
    import shapely

    return int(shapely.get_num_coordinates(geometry))
