"""The lock of the development environment is public and complete, and agrees with pyproject.toml and the constraints.

Where it does not, run `make lock`.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LOCK = tomllib.loads((ROOT / "uv.lock").read_text(encoding="utf-8"))
CONSTRAINTS = (ROOT / ".ci" / "constraints.txt").read_text(encoding="utf-8").splitlines()


def locked() -> list[dict[str, Any]]:
    """The packages of the lock, without the project itself."""
    return [package for package in LOCK["package"] if package["name"] != PROJECT["name"]]


def test_every_package_comes_from_the_public_index() -> None:
    assert {package["source"].get("registry") for package in locked()} == {"https://pypi.org/simple"}
    urls = re.findall(r'\burl = "([^"]+)"', (ROOT / "uv.lock").read_text(encoding="utf-8"))
    assert urls
    assert [url for url in urls if not url.startswith("https://files.pythonhosted.org/")] == []


def test_the_lock_holds_no_path_of_a_machine() -> None:
    text = (ROOT / "uv.lock").read_text(encoding="utf-8") + "\n".join(CONSTRAINTS)
    assert not re.search(r"file:|[\"' ]/\w", text)


def test_the_lock_was_made_from_this_project_file() -> None:
    own = next(package for package in LOCK["package"] if package["name"] == PROJECT["name"])
    asked = {(canonicalize_name(r.name), str(r.specifier), "") for r in map(Requirement, PROJECT["dependencies"])}
    for extra, requirements in PROJECT["optional-dependencies"].items():
        asked |= {(canonicalize_name(r.name), str(r.specifier), extra) for r in map(Requirement, requirements)}
    written = {
        (
            row["name"],
            str(SpecifierSet(row.get("specifier", ""))),
            "".join(re.findall(r"extra == '([^']+)'", row.get("marker", ""))),
        )
        for row in own["metadata"]["requires-dist"]
    }
    assert written == asked
    assert LOCK["requires-python"] == PROJECT["requires-python"]


def test_the_constraints_are_the_locks_versions() -> None:
    rows = [Requirement(line) for line in CONSTRAINTS]
    assert {(row.name, str(row.specifier)) for row in rows} == {(p["name"], f"=={p['version']}") for p in locked()}


def test_every_promised_python_is_tested_on_both_machines() -> None:
    promised = [c.rpartition(" ")[2] for c in PROJECT["classifiers"] if re.search(r"Python :: 3\.\d+$", c)]
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    tested = re.search(r"python: \[(.+)\]", workflow)
    machines = re.search(r"machine: \[(.+)\]", workflow)
    assert tested is not None and machines is not None
    assert re.findall(r"3\.\d+", tested.group(1)) == promised
    assert machines.group(1).split(", ") == ["ubuntu-latest", "ubuntu-24.04-arm"]
    assert PROJECT["requires-python"] == f">={promised[0]}"
    assert "make test" in workflow
    assert "make test" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
