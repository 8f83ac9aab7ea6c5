"""Sentences of NMEA 0183 that pynmea2 does not have. A definition enters its sentence in pynmea2's table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pynmea2


class THS(pynmea2.TalkerSentence):  # type: ignore[misc]  # pynmea2 is untyped
    """True heading and status."""

    fields = (("True heading", "heading", float), ("Mode", "mode"))


TYPES: Mapping[str, Any] = pynmea2.TalkerSentence.sentence_types
"""The type of each sentence that is known."""
