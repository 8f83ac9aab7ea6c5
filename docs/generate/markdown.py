"""Markdown from values: tables, code, anchors."""

from __future__ import annotations

import inspect
import re
import unicodedata
from collections.abc import Iterable, Sequence


def code(text: object) -> str:
    """`text` in code style; nothing for nothing."""
    shown = str(text)
    return f"`{shown}`" if shown else ""


def anchored(text: str) -> str:
    """Code that a link can point to: the anchor is the text in lower case."""
    return f"`{text}`{{#{text.lower()}}}"


def cell(text: str) -> str:
    """Text that stays within one cell of a table."""
    return " ".join(text.split()).replace("|", "\\|")


def table(headers: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table, with an empty line after it; nothing where there are no rows."""
    lines = ["| " + " | ".join(cell(text) for text in row) + " |" for row in rows]
    if not lines:
        return ""
    return "\n".join(["| " + " | ".join(headers) + " |", "|" + " --- |" * len(headers), *lines]) + "\n\n"


def section(level: int, title: str, *parts: str) -> str:
    """A heading and what stands under it."""
    body = "\n\n".join(part.strip("\n") for part in parts if part)
    return f"{'#' * level} {title}\n\n{body}\n\n"


def page(title: str, *parts: str) -> str:
    """A whole page."""
    return section(1, title, *parts).rstrip("\n") + "\n"


def summary(thing: object) -> str:
    """The first paragraph of a docstring, on one line."""
    doc = inspect.getdoc(thing) or ""
    made = doc.startswith(f"{getattr(thing, '__name__', '')}(")  # by `dataclass`, for want of one
    return "" if made else " ".join(doc.split("\n\n")[0].split())


def number(value: float) -> str:
    """A number as a person writes it: no trailing zeros, no exponent for moderate sizes."""
    shown = str(int(value)) if value == int(value) and abs(value) < 1e12 else f"{value:.6g}"
    return shown.replace("-", "−")


def sentence(text: str) -> str:
    """`text` with a full stop."""
    return text if not text or text.endswith((".", "!", "?", "…")) else f"{text}."


_SLUG_DROPPED = re.compile(r"[^\w\s-]")


def slug(title: str) -> str:
    """The anchor of a heading, as MkDocs makes it."""
    plain = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode()
    return re.sub(r"[-\s]+", "-", _SLUG_DROPPED.sub("", plain).strip().lower())
