"""A client of MAVLink's events interface, written from its description (MAVLink guide, "Events Interface"; libevents,
README), that shares nothing with the boat."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

_TYPES = {"uint8_t": "B", "int8_t": "b", "uint16_t": "H", "int16_t": "h", "uint32_t": "I", "int32_t": "i", "float": "f"}
_PROTOCOL = 8


@dataclass
class Parsed:
    """One event with its metadata. `level`: the external one."""

    name: str
    group: str
    kind: str
    text: str
    remedy: str
    level: int
    values: list[Any]


class Metadata:
    """The events file of a component."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        (self.component,) = content["components"].values()
        (number,) = content["components"]
        self.events: dict[int, tuple[str, Mapping[str, Any]]] = {}
        for group, events in self.component["event_groups"].items():
            for sub_id, event in events["events"].items():
                assert int(sub_id) < 1 << 24
                self.events[int(number) << 24 | int(sub_id)] = group, event
        self.enums: Mapping[str, Any] = self.component["enums"]

    def parse(self, event: Any) -> Parsed:
        group, row = self.events[event.id]
        kinds = [argument["type"] for argument in row["arguments"]]
        base = [self.enums[kind]["type"] if kind in self.enums else kind for kind in kinds]
        layout = "<" + "".join(_TYPES[kind] for kind in base)
        values = list(struct.unpack_from(layout, bytes(event.arguments)))
        shown = [self._shown(kind, value) for kind, value in zip(kinds, values, strict=True)]
        text = re.sub(r"\{(\d+)\}", lambda found: shown[int(found[1]) - 1], row["message"])
        return Parsed(
            row["name"],
            group,
            row.get("type", ""),
            text,
            row.get("description", ""),
            event.log_levels & 0xF,
            values,
        )

    def _shown(self, kind: str, value: Any) -> str:
        entries = self.enums.get(kind, {}).get("entries", {})
        return entries[str(value)]["description"] if str(value) in entries else str(value)

    def group_of(self, custom_mode: int) -> int:
        groups = self.component["navigation_mode_groups"]["groups"]
        return next(int(number) for number, modes in groups.items() if custom_mode in modes)


@dataclass
class Report:
    """What the protocol of health and arming checks gives."""

    can_arm: int
    can_run: int
    checks: list[Parsed]
    parts: dict[str, tuple[bool, bool, bool]] = field(default_factory=dict)  # present, error, warning

    def of(self, group: int) -> list[str]:
        return [check.text for check in self.checks if check.values[0] >> group & 1]


class EventsClient:
    """`take(message)` each message of the boat; it asks again by `ask(first, last)` for what it missed."""

    def __init__(self, metadata: Metadata, ask: Callable[[int, int], None]) -> None:
        self._metadata = metadata
        self._ask = ask
        self._latest: int | None = None
        self._report: Report | None = None
        self.events: list[Parsed] = []
        self.reports: list[Report] = []
        self.lost = 0

    def take(self, message: Any) -> None:
        kind = message.get_type()
        if kind == "EVENT":
            self._on_event(message)
        elif kind == "CURRENT_EVENT_SEQUENCE":
            self._on_sequence(message)
        elif kind == "RESPONSE_EVENT_ERROR":
            self._on_error(message)

    def _on_sequence(self, message: Any) -> None:
        if message.flags & 1 or self._latest is None:
            self._latest = message.sequence
        if 0 < (message.sequence - self._latest) % 65536 < 32768:
            self._ask((self._latest + 1) % 65536, message.sequence)

    def _on_error(self, message: Any) -> None:
        if self._latest is not None and message.sequence == (self._latest + 1) % 65536:
            oldest = message.sequence_oldest_available
            self.lost += (oldest - self._latest - 1) % 65536
            self._latest = (oldest - 1) % 65536
            self._report = None
            self._ask(oldest, oldest)

    def _on_event(self, message: Any) -> None:
        if self._latest is None:
            self._latest = (message.sequence - 1) % 65536
        ahead = (message.sequence - self._latest) % 65536
        if ahead == 1:
            self._latest = message.sequence
            self._sort(self._metadata.parse(message))
        elif ahead < 32768 and ahead:
            self._ask((self._latest + 1) % 65536, (self._latest + 1) % 65536)

    def _sort(self, event: Parsed) -> None:
        if event.group == "default":
            self.events.append(event)
        elif event.kind == "summary" and event.group == "arming_check":
            self._report = Report(event.values[3], event.values[4], [])
        elif self._report is None:
            return
        elif event.kind == "summary":
            _, present, error, warning = event.values
            entries = self._metadata.enums["health_component_t"]["entries"]
            for bit, entry in entries.items():
                flags = [bool(bits & int(bit)) for bits in (present, error, warning)]
                self._report.parts[entry["name"]] = (flags[0], flags[1], flags[2])
            self.reports.append(self._report)
            self._report = None
        else:
            assert event.level != _PROTOCOL
            self._report.checks.append(event)
