"""What a person most likely meant who wrote a line that is not TOML."""

from __future__ import annotations

import re

_CURLY = "“”„‘’«»"
_UNSEEN = {  # characters that word processors and web pages put in place of plain ones
    "\u2212": ("minus sign U+2212", "type the hyphen of the keyboard, -"),
    "\u2013": ("dash U+2013", "type the hyphen of the keyboard, -"),
    "\u00a0": ("non-breaking space U+00A0", "type a plain space"),
    "\u202f": ("non-breaking space U+202F", "type a plain space"),
    "\u200b": ("space of no width U+200B", "leave it out"),
    "\ufeff": ("byte order mark U+FEFF", "leave it out"),
}
_REMEDIES: tuple[tuple[re.Pattern[str], str], ...] = (
    (re.compile(f"[{_CURLY}]"), 'text stands in straight quotes, "like this"'),
    (re.compile(r"=\s*[-+]?\d+,\d+\s*(?:#|$)"), "a number has a decimal point, not a comma"),
    (
        re.compile(r"=\s*[-+]?\d+(?:\.\d+)?\s*[A-Za-zµ°²%/]+\s*(?:#|$)"),
        "a number has no unit behind it: the end of its key says it",
    ),
    (re.compile(r"=\s*(?:True|False|TRUE|FALSE|yes|no|on|off)\b"), "true or false, in small letters"),
    (re.compile(r"=\s*[A-Za-z]"), 'text stands in quotes, "like this"'),
    (re.compile(r"=\s*(?:#|$)"), "the value is missing"),
)


def toml_mistake(reason: str, line: str) -> str:
    """tomllib's reason of a fault in `line`, in the words of a person who edits it, with the remedy where one is
    plain."""
    plain = line.strip()
    if reason.startswith("Cannot "):
        return _said_twice(plain)
    if plain.partition("#")[0].count('"') % 2:
        return "a quote is not closed"
    if unseen := _unseen(line):
        return unseen
    if plain and not plain.startswith(("[", "#")) and "=" not in plain:
        return "a line reads `key = value`"
    return next((text for pattern, text in _REMEDIES if pattern.search(plain)), reason)


def _unseen(line: str) -> str:
    """The character outside quotes and comment that looks like another, and what to type; empty without one."""
    bare = re.sub(r'"[^"]*"', "", line).partition("#")[0]
    return next((f"a {name}: {remedy}" for sign, (name, remedy) in _UNSEEN.items() if sign in bare), "")


def _said_twice(line: str) -> str:
    header = re.match(r"(\[+)\s*([\w.]+)", line)
    if header is None:
        return f"'{line.partition('=')[0].strip()}' stands there twice: leave out one"
    brackets, name = header.groups()
    if brackets == "[[":
        return f"[{name}] above is one table: each row of a list begins with [[{name}]]"
    return f"[{name}] stands there twice: join the two, or begin each with [[{name}]] if they are rows of a list"
