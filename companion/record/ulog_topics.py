"""What a topic of a ULog file is made of."""

from __future__ import annotations

import struct
from dataclasses import dataclass

_CODES = {"uint64_t": "Q", "double": "d", "float": "f", "uint8_t": "B", "int32_t": "i", "float[4]": "4f"}


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic; the timestamp comes first."""

    name: str
    fields: tuple[tuple[str, str], ...]  # (type, name)

    @property
    def definition(self) -> bytes:
        """The ULog format definition."""
        return f"{self.name}:{''.join(f'{kind} {name};' for kind, name in self.fields)}".encode()

    @property
    def layout(self) -> struct.Struct:
        """The packing of a data message: its message id, then the fields."""
        return struct.Struct("<H" + "".join(_CODES[kind] for kind, _ in self.fields))


def topic(name: str, **kinds: str) -> Topic:
    """A topic: names of fields by type, separated by spaces. `quaternion`: fields that are one."""
    fields = [("uint64_t", "timestamp")]
    for kind, names in kinds.items():
        fields += [("float[4]" if kind == "quaternion" else kind, field) for field in names.split()]
    return Topic(name, tuple(fields))
