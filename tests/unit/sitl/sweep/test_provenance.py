"""What code a run was sailed by: every change of it has another name."""

import subprocess
from pathlib import Path

from sitl.sweep.provenance import commit_of


def git(root: Path, *words: str) -> None:
    owner = ("-c", "user.name=nobody", "-c", "user.email=nobody@example.org")
    subprocess.run(["git", *owner, *words], cwd=root, check=True, capture_output=True)


def test_a_new_file_is_a_change_too(tmp_path: Path) -> None:
    """A new vessel among the bundled ones was sailed again only after its first commit."""
    vessels = tmp_path / "companion" / "vessels"
    vessels.mkdir(parents=True)
    (vessels / "old.toml").write_text("length_m = 2.0\n", encoding="utf-8")
    (tmp_path / ".gitignore").write_text("out/\n", encoding="utf-8")
    git(tmp_path, "init")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-m", "first")
    clean = commit_of(tmp_path)
    assert len(clean) == 10 and "+" not in clean
    (tmp_path / "companion" / "out").mkdir()
    for place in ("notes.txt", "companion/out/log.csv"):
        (tmp_path / place).write_text("of no run", encoding="utf-8")
    assert commit_of(tmp_path) == clean
    names = [clean]
    for text in ("length_m = 3.0\n", "length_m = 4.0\n"):
        (vessels / "new é.toml").write_text(text, encoding="utf-8")
        names.append(commit_of(tmp_path))
    (vessels / "old.toml").write_text("length_m = 5.0\n", encoding="utf-8")
    names.append(commit_of(tmp_path))
    assert len(set(names)) == 4 and all(name.startswith(clean) for name in names)


def test_an_installed_package_has_a_version(tmp_path: Path) -> None:
    assert commit_of(tmp_path).startswith("v")
