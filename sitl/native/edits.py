"""Changes of a source text by the places of its syntax tree."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field


@dataclass
class Edits:
    """Insertions into and removals from a text, by place."""

    text: str
    starts: list[int] = field(default_factory=list)
    edits: list[tuple[int, int, str]] = field(default_factory=list)

    def __post_init__(self) -> None:
        at = 0
        for line in self.text.encode().splitlines(keepends=True):
            self.starts.append(at)
            at += len(line)
        self.starts.append(at)

    def start(self, node: ast.expr | ast.stmt | ast.arg) -> int:
        """The byte at which the node begins."""
        return self.starts[node.lineno - 1] + node.col_offset

    def end(self, node: ast.expr | ast.stmt) -> int:
        """The byte after the node."""
        assert node.end_lineno is not None and node.end_col_offset is not None
        return self.starts[node.end_lineno - 1] + node.end_col_offset

    def replace(self, start: int, end: int, text: str) -> None:
        """Put `text` for the bytes from `start` to `end`."""
        self.edits.append((start, end, text))

    def insert(self, at: int, text: str) -> None:
        """Put `text` before the byte `at`."""
        self.edits.append((at, at, text))

    def done(self) -> str:
        """The text with all changes."""
        data = self.text.encode()
        for start, end, text in sorted(self.edits, key=lambda edit: edit[:2], reverse=True):
            data = data[:start] + text.encode() + data[end:]
        return data.decode()
