"""Make a virtual environment with pip in it, also where Debian left `ensurepip` out of Python.

Usage: python3 .ci/make_venv.py DIRECTORY
"""

import re
import subprocess
import sys
import tempfile
import urllib.parse
import urllib.request
import venv
from os import environ
from pathlib import Path


def main(directory: Path) -> None:
    if sys.version_info < (3, 11):  # noqa: UP036  this file runs under whatever Python there is
        sys.exit(f"Python 3.11 or newer is needed, this is {sys.version.split()[0]}: make PYTHON=python3.11 …")
    if directory.is_symlink():
        directory.unlink()  # of another checkout: to clear it would take its packages away
    try:
        import ensurepip  # noqa: F401  Debian's python3 lacks it without the package python3-venv
    except ImportError:
        venv.create(directory, with_pip=False, clear=True, symlinks=True)
        install_pip(directory / "bin" / "python")
    else:
        venv.create(directory, with_pip=True, clear=True, symlinks=True)


def install_pip(python: Path) -> None:
    """A wheel of pip can install itself: fetch the newest one from the package index."""
    index = environ.get("PIP_INDEX_URL", "https://pypi.org/simple").rstrip("/") + "/pip/"
    with urllib.request.urlopen(index) as page:
        links = re.findall(r'href="([^"]+pip-(\d+(?:\.\d+)*)-py3-none-any\.whl[^"]*)"', page.read().decode())
    if not links:
        sys.exit("no pip found in the package index; install it with: sudo apt install python3-venv")
    link, version = max(links, key=lambda found: [int(part) for part in found[1].split(".")])
    with tempfile.TemporaryDirectory() as folder:
        wheel = Path(folder) / f"pip-{version}-py3-none-any.whl"
        urllib.request.urlretrieve(urllib.parse.urljoin(index, link), wheel)
        subprocess.run([python, wheel / "pip", "install", "--quiet", "--no-index", wheel], check=True)


main(Path(sys.argv[1]))
