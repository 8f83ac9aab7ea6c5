"""A compiled build counts only while it fits its sources and this Python."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from companion import native


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A build of two files, with a library that nobody loads."""
    finders, status = list(sys.meta_path), native.status
    for name in ("a.py", "b.py"):
        (tmp_path / name).write_text(f"# {name}\n")
    built = tmp_path / "_native"
    built.mkdir()
    (built / f"{native.LIBRARY}{native.SUFFIX}").write_bytes(b"")
    files = ["a.py", "b.py"]
    marks = {"digest": native.digest(tmp_path, files), "stamp": native.stamp(tmp_path, files)}
    index = {"for": "x", "by": "mypyc", "modules": ["made.a"], "files": files, **marks}
    (built / "index.json").write_text(json.dumps(index))
    yield built
    sys.meta_path[:] = finders
    native.status = status


def found(name: str) -> bool:
    return any(finder.find_spec(name, None) for finder in sys.meta_path[:1])


def test_a_build_as_new_as_its_sources_is_used(folder: Path) -> None:
    assert native.install(folder.parent, folder, "") == native.status == "native (1 modules, mypyc)"
    assert found("made.a") and not found("made.b")


@pytest.mark.parametrize("name", ["a.py", "b.py"])
def test_a_changed_source_makes_it_stale(folder: Path, name: str) -> None:
    with (folder.parent / name).open("a") as file:
        file.write("#")
    assert native.install(folder.parent, folder, "") == "interpreted: the native build is older than the sources"
    assert not found("made.a")


def test_sources_with_the_times_of_the_build_are_not_read_again(folder: Path) -> None:
    assert native.stamp(folder.parent, ["a.py"]) != native.stamp(folder.parent, ["b.py"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(native, "digest", lambda *_: pytest.fail("read"))
        assert native.install(folder.parent, folder, "").startswith("native")


def test_sources_of_other_times_count_by_their_contents(folder: Path) -> None:
    os.utime(folder.parent / "a.py", ns=(1, 1))
    assert native.install(folder.parent, folder, "").startswith("native")


def test_a_source_changed_at_the_same_size_makes_it_stale(folder: Path) -> None:
    (folder.parent / "a.py").write_text("# b.py\n")
    os.utime(folder.parent / "a.py", ns=(1, 1))
    assert native.install(folder.parent, folder, "") == "interpreted: the native build is older than the sources"


def test_a_missing_source_makes_it_stale(folder: Path) -> None:
    (folder.parent / "b.py").unlink()
    assert native.install(folder.parent, folder, "") == "interpreted"


def test_a_build_of_another_python_is_left(folder: Path) -> None:
    library = folder / f"{native.LIBRARY}{native.SUFFIX}"
    library.rename(folder / "usv__mypyc.cpython-39-vax.so")
    assert native.install(folder.parent, folder, "") == "interpreted: the native build is for another Python (x)"


def test_it_can_be_switched_off(folder: Path) -> None:
    assert native.install(folder.parent, folder, "0") == "interpreted, by USV_NATIVE=0"
    assert not found("made.a")


def test_it_can_be_required(folder: Path) -> None:
    assert native.install(folder.parent, folder, "require").startswith("native")
    (folder / "index.json").unlink()
    with pytest.raises(ImportError, match="make native"):
        native.install(folder.parent, folder, "require")


def test_without_a_build_all_is_interpreted(tmp_path: Path) -> None:
    before = native.status
    try:
        assert native.install(tmp_path, tmp_path / "_native", "") == "interpreted"
    finally:
        native.status = before
