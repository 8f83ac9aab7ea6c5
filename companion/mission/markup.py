"""Elements of a file with nested names, attributes and text: XML, or JSON that a converter made from it.

The XML parser refuses what plan files never need and attackers use: document types, entities, external content. The
number of elements and their depth are limited.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from io import StringIO
from typing import Any
from xml.sax import SAXParseException
from xml.sax.handler import ContentHandler
from xml.sax.xmlreader import AttributesImpl, InputSource

from defusedxml import DefusedXmlException
from defusedxml.sax import make_parser

from companion.mission.plan_file import PlanFileError

MOST_ELEMENTS = 300_000
DEEPEST = 60
# Keys that converters write: fast-xml-parser, xmltodict, BadgerFish, x2js and others
_ATTRIBUTE_PREFIXES = ("@_", "@", "-", "_", "$")
_ATTRIBUTE_OBJECTS = ("$", "@", "_attributes", "@attributes", "attributes", "attr")
_TEXTS = ("#text", "_text", "$t", "__text", "_", "text", "content", "$")


@dataclass(slots=True)
class Element:
    """One element. `name` has no namespace. `place` is the file and line, or the path in JSON, for error texts."""

    name: str
    place: str
    attributes: Mapping[str, str]
    text: str = ""
    children: list[Element] = field(default_factory=list)

    def walk(self) -> Iterator[Element]:
        """This element and all below it, in the order of the file."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting.extend(reversed(element.children))

    def all(self, name: str) -> list[Element]:
        """The elements of that name among this one and all below it, in the order of the file."""
        return [element for element in self.walk() if element.name == name]

    def child(self, name: str) -> Element | None:
        """The first direct child of that name, or None."""
        return next((element for element in self.children if element.name == name), None)


def local_name(name: str) -> str:
    """The name without its namespace prefix: `rtept` for `gpx:rtept`."""
    return name.rpartition(":")[2]


# --- XML -----------------------------------------------------------------------------------------------------------


class _TooMuch(Exception):
    """The file has more elements, or deeper ones, than a plan needs."""


class _Builder(ContentHandler):
    """Builds a tree of elements, each with its line, from SAX events."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._name = name
        self._open: list[Element] = []
        self._texts: list[list[str]] = []
        self._count = 0
        self._locator: Any = None
        self.root: Element | None = None

    def setDocumentLocator(self, locator: Any) -> None:
        """Keep the locator, which has the line numbers."""
        self._locator = locator

    def startElement(self, name: str, attrs: AttributesImpl) -> None:
        """Add an element below the open one. Raises _TooMuch beyond the limits."""
        self._count += 1
        if self._count > MOST_ELEMENTS:
            raise _TooMuch(f"more than {MOST_ELEMENTS} elements; keep one route in the file")
        if len(self._open) >= DEEPEST:
            raise _TooMuch(f"elements nested deeper than {DEEPEST}; this is no route")
        attributes = {local_name(key): str(value) for key, value in attrs.items()}
        element = Element(local_name(name), f"{self._name}:{self._locator.getLineNumber()}", attributes)
        if self._open:
            self._open[-1].children.append(element)
        else:
            self.root = element
        self._open.append(element)
        self._texts.append([])

    def endElement(self, name: str) -> None:
        """Close the open element and set its text."""
        self._open.pop().text = "".join(self._texts.pop())

    def characters(self, content: str) -> None:
        """Collect text of the open element."""
        self._texts[-1].append(content)


def read_xml(name: str, text: str) -> Element:
    """The root element. Raises PlanFileError with file and line for invalid XML and for XML that no plan file
    needs."""
    builder = _Builder(name)
    source = InputSource()
    source.setCharacterStream(StringIO(text.removeprefix("\ufeff")))
    parser = make_parser()
    parser.forbid_dtd = True
    parser.setContentHandler(builder)
    try:
        parser.parse(source)
    except SAXParseException as error:
        raise PlanFileError(
            [f"{name}:{error.getLineNumber()}: not well-formed XML: {error.getMessage()}; save the file again"]
        ) from error
    except DefusedXmlException as error:
        raise PlanFileError(
            [f"{name}: it declares a document type or entities (DTD), which no route needs; remove that part"]
        ) from error
    except (_TooMuch, ValueError) as error:
        raise PlanFileError([f"{name}: {error}"]) from error
    if builder.root is None:
        raise PlanFileError([f"{name}: no element in it; save the file again"])
    return builder.root


# --- JSON ----------------------------------------------------------------------------------------------------------


def read_json(name: str, text: str) -> Any:
    """The value of a JSON text. Raises PlanFileError with file, line and column."""
    try:
        return json.loads(text.removeprefix("\ufeff"), parse_constant=_no_constant, parse_int=_whole_number)
    except (ValueError, RecursionError) as error:
        where = (
            f"{name}:{error.lineno}:{error.colno}: {error.msg}"
            if isinstance(error, json.JSONDecodeError)
            else f"{name}: {error}"
        )
        raise PlanFileError([f"{where}; save the file again, or correct the JSON"]) from error


def from_json(name: str, content: Mapping[str, Any]) -> Element:
    """The root of the elements in JSON that was made from XML. Keys are names, lists are repeated elements; attributes
    have a prefix or an object of their own; text is a plain value or has a key such as `#text`. A place is a path such
    as `gpx.rte.rtept[3]`. Raises PlanFileError for too many or too deep elements."""
    root = Element("", name, {})
    waiting: list[tuple[Element, str, Mapping[str, Any], int]] = [(root, "", content, 0)]
    count = 0
    while waiting:
        parent, way, members, depth = waiting.pop()
        for key, value in members.items():
            for number, one in enumerate(value) if isinstance(value, list) else ((None, value),):
                count += 1
                if count > MOST_ELEMENTS or depth >= DEEPEST:
                    raise PlanFileError(
                        [f"{name}: more elements than a route has, or nested deeper; keep one route in the file"]
                    )
                here = f"{way}{key}" if number is None else f"{way}{key}[{number}]"
                element = _json_element(local_name(key), f"{name}: {here}", one)
                parent.children.append(element)
                if isinstance(one, Mapping):
                    inner = {k: v for k, v in one.items() if k not in _ATTRIBUTE_OBJECTS and isinstance(v, list | dict)}
                    waiting.append((element, f"{here}.", inner, depth + 1))
    return root


def _json_element(name: str, place: str, value: Any) -> Element:
    if not isinstance(value, Mapping):
        return Element(name, place, {}, _plain(value))
    attributes: dict[str, str] = {}
    leaves: list[Element] = []
    for key, inner in value.items():
        if key in _ATTRIBUTE_OBJECTS and isinstance(inner, Mapping):
            attributes |= {
                local_name(k.lstrip("@-_$")): _plain(v) for k, v in inner.items() if not isinstance(v, list | dict)
            }
        elif not isinstance(inner, list | dict) and key not in _TEXTS:
            attributes[local_name(_bare(key))] = _plain(inner)
            leaves.append(Element(local_name(key), f"{place}.{key}", {}, _plain(inner)))
    text = next((_plain(value[key]) for key in _TEXTS if key in value and not isinstance(value[key], list | dict)), "")
    return Element(name, place, attributes, text, leaves)


def _bare(key: str) -> str:
    prefix = next((prefix for prefix in _ATTRIBUTE_PREFIXES if key.startswith(prefix) and len(key) > len(prefix)), "")
    return key.removeprefix(prefix)


def _plain(value: Any) -> str:
    return "" if value is None else str(value)


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is no JSON; write null for what is not given")


def _whole_number(text: str) -> int | float:
    """A whole number; one with 20 digits or more becomes infinite, which the check of its field refuses."""
    return int(text) if len(text) < 20 else math.inf
