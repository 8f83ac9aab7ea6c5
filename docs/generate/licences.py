"""licences.md: the packages that a boat installs, their versions and licences."""

from __future__ import annotations

import re
from importlib import metadata
from pathlib import Path

from docs.generate.markdown import code, page, table
from docs.generate.source import ROOT

REQUIREMENTS = ROOT / ".ci" / "requirements-boat.txt"
_INTRODUCTION = """The companion itself has the MIT licence. On a boat these packages are installed beside it, by
`.ci/requirements-boat.txt`. Licences are those that the packages state in their metadata.

`make sbom` writes the same list for tools: a software bill of materials (CycloneDX, JSON) with the hash of each."""
_PIN = re.compile(r"^([A-Za-z0-9._-]+)==([^ ;\\]+)(?: *; *([^\\]*?))?(?: *\\)?$")
_LONGEST = 60  # characters; longer texts are whole licences
_NOT_HERE = "not stated"


def licences() -> str:
    """The page."""
    rows = [(name, code(version), marker, licence_of(name)) for name, version, marker in pins()]
    return page("Licences", _INTRODUCTION, table(("package", "version", "only where", "licence"), rows))


def pins(path: Path = REQUIREMENTS) -> list[tuple[str, str, str]]:
    """(name, version, marker) of each package of a requirements file."""
    found = map(_PIN.match, path.read_text(encoding="utf-8").splitlines())
    return [(match[1], match[2], (match[3] or "").strip()) for match in found if match]


def licence_of(name: str) -> str:
    """The licence that an installed package states."""
    try:
        about = metadata.metadata(name)
    except metadata.PackageNotFoundError:
        return "see its page: not installed where this was made"
    if expression := about.get_all("License-Expression"):
        return str(expression[0])
    classifiers = [line.split(" :: ")[-1] for line in about.get_all("Classifier") or () if line.startswith("License")]
    text = str((about.get_all("License") or [""])[0]).strip()
    stated = text if text and len(text) <= _LONGEST and "\n" not in text else ", ".join(classifiers)
    return stated or _NOT_HERE
