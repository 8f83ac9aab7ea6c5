"""Features of a chart, drawn in metres around a place."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from companion.config.chart import ChartFeature
from companion.core.geodesy import LocalFrame

FRAME = LocalFrame(63.442, 10.4)


def feature(
    kind: str, drawn: BaseGeometry, radius_m: float = 0.0, depth_m: float | None = None, frame: LocalFrame = FRAME
) -> ChartFeature:
    """`drawn`: in (north_m, east_m) of `frame`."""

    def project(places: np.ndarray) -> np.ndarray:
        return np.array([frame.to_geodetic(north, east)[::-1] for north, east in places.tolist()])

    return ChartFeature(kind, shapely.transform(drawn, project), radius_m, depth_m)
