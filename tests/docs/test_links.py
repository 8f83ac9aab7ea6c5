"""Every link leads somewhere: to a page, to a heading in it, to a file."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from companion.config.vessel import bundled
from tests.docs.pages import ROOT, anchors, generated, label, links, spans, written

_OUR_FILE = re.compile(r"(?:companion|sitl|gcs_plugins|tests|mission_files|docs)/[\w./-]*\w\.\w+")


@pytest.mark.parametrize("path", written(), ids=label)
def test_every_link_leads_somewhere(path: Path) -> None:
    dead = []
    for target in links(path):
        file, _, anchor = target.partition("#")
        page = (path.parent / file).resolve() if file else path
        text = generated().get(page)
        if text is None:
            if not page.exists():
                dead.append(f"{target}: no such file")
                continue
            text = page.read_text(encoding="utf-8") if page.suffix == ".md" else ""
        if anchor and anchor not in anchors(text):
            dead.append(f"{target}: no such heading")
    assert not dead, f"{label(path)}: {'; '.join(dead)}"


@pytest.mark.parametrize("path", written(), ids=label)
def test_every_file_of_ours_that_is_named_exists(path: Path) -> None:
    named = [span for span in spans(path) if _OUR_FILE.fullmatch(span)]
    made = {page.relative_to(ROOT).as_posix() for page in generated()}
    missing = [name for name in named if not (ROOT / name).exists() and name not in made]
    assert not missing, f"{label(path)}: {', '.join(missing)}"


def test_the_readme_names_every_bundled_vessel() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert not [name for name in bundled() if f"`{name}`" not in text]


def test_the_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_bytes()) <= 12_288
