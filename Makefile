# make run      a simulated ReVolt for any ground station on this machine, and its live page; Ctrl-C ends both
# make test     everything that CI runs
# make lint     the linters, the import contracts, the type checker and the rules of the house, which make test runs too
# make bench    figures of speed; nothing is asserted; ARGS=--keep stores some of them for this commit
# make growth   how costs grow with missions, links, traffic, vessels, pages and logs (minutes)
# make native   compiles the arithmetic: several times as fast; needs a C compiler and some minutes; JOBS=N
# make docs     the documentation as a site in out/site, checked; nothing is fetched when it is read
# make results  the measured tables of the documentation anew (hours; goes on where it was cut off)
# make matrix   the fault matrix of the documentation anew (an hour)
# make scenarios  every scenario over many seeds (long)
# make wheel    the wheel and the source archive, in dist/
# make hooks    runs the quick checks before each commit
# make sbom     the packages of a boat as a software bill of materials (CycloneDX), dist/usv_companion.cdx.json
# make lock     writes uv.lock, .ci/constraints.txt and .ci/requirements-boat.txt anew; UPGRADE=--upgrade takes the newest versions
# Each sets up its own virtual environment in .venv, with the versions that uv.lock names.

# Without bytecode each process that a test or a person starts would compile all modules anew.
unexport PYTHONDONTWRITEBYTECODE

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CONSTRAINTS := .ci/constraints.txt
BOAT := .ci/requirements-boat.txt
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
INSTALL := $(PIP) install --constraint $(CONSTRAINTS)
IMPORTED := tests/__pycache__/.imported
STYLE := $(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/lint-imports

.PHONY: run test lint style types house bench growth native docs results matrix scenarios wheel sbom hooks lock clean

run: $(VENV)/.installed
	@$(BIN)/companion run revolt --sitl --console --control $(ARGS)

# One process more than two cores, since many tests wait for another process; the types are checked beside them.
# In a new checkout the tests are imported once before, beside the linters: that leaves bytecode, which three processes
# would each make. Later there are few files to compile, and the import would take as long as that of each process.
test: $(VENV)/.installed-test
	@echo "the linters and $(BIN)/mypy, beside $(BIN)/python -m pytest -n 3"
	@$(BIN)/mypy & types=$$!; \
	$(if $(wildcard $(IMPORTED)),:,$(BIN)/python -m pytest -W ignore --collect-only -m "not sweep") >/dev/null 2>&1 & imported=$$!; \
	$(STYLE) || { kill $$types $$imported 2>/dev/null; exit 1; }; \
	wait $$imported && touch $(IMPORTED); \
	$(BIN)/python -m pytest -n 3 --dist worksteal -m "not sweep"; tests=$$?; \
	wait $$types || { echo "mypy found errors: make types"; exit 1; }; \
	exit $$tests

lint: style types house

style: $(VENV)/.installed-test
	$(STYLE)

types: $(VENV)/.installed-test
	$(BIN)/mypy

house: $(VENV)/.installed-test
	$(BIN)/python -m pytest -q tests/architecture

bench: $(VENV)/.installed-test
	$(BIN)/python -m tests.bench $(ARGS)

growth: $(VENV)/.installed-test
	$(BIN)/python -m tests.bench_growth $(ARGS)

native: $(VENV)/.installed-test
	USV_NATIVE=0 $(BIN)/python -m sitl.native $(if $(JOBS),--jobs $(JOBS)) $(if $(filter-out default,$(origin CC)),--cc '$(CC)')
	@$(BIN)/companion --version

docs: $(VENV)/.installed-docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet
	@echo "out/site/index.html"

results: $(VENV)/.installed
	$(BIN)/python -m docs.results.measure $(ARGS)

matrix: $(VENV)/.installed
	$(BIN)/python -m docs.results.faults $(ARGS)

scenarios: $(VENV)/.installed-test
	$(BIN)/python -m pytest -n 2 --dist worksteal -m sweep tests

wheel: $(VENV)/.installed-test
	$(BIN)/python -m hatchling build -d dist

hooks: $(VENV)/.installed-test
	$(INSTALL) --editable ".[dev]"
	$(BIN)/pre-commit install

# The public index is named, so that a mirror of this machine does not get into the lock.
lock: $(VENV)/.made
	$(PIP) install "uv>=0.9"
	$(BIN)/uv lock --quiet --default-index https://pypi.org/simple $(UPGRADE)
	$(BIN)/uv export --quiet --frozen --all-extras --no-emit-project --no-hashes --no-annotate --no-header --output-file $(CONSTRAINTS)
	$(BIN)/uv export --quiet --frozen --extra can --no-emit-project --no-annotate --no-header --output-file $(BOAT)

sbom: $(VENV)/.made
	$(PIP) install "uv>=0.9"
	@mkdir -p dist
	$(BIN)/uv export --quiet --frozen --extra can --no-emit-project --format cyclonedx1.5 --output-file dist/usv_companion.cdx.json
	@echo "dist/usv_companion.cdx.json"

# What the first set-up takes a minute for.
PACKAGES = $$(sed -n '/^dependencies/,/^]/s/^ *"\([A-Za-z0-9-]*\).*/\1/p' pyproject.toml | tr '\n' ' ')
TELL = @echo "Installing into $(VENV), which takes a minute or two the first time: $(PACKAGES)and what these need$(1)"

# A stamp, since bin/python is a link to a file as old as the machine's Python.
$(VENV)/.made: .ci/make_venv.py
	@echo "Making a virtual environment in $(VENV)"
	$(PYTHON) .ci/make_venv.py $(VENV)
	@touch $@

$(VENV)/.installed: pyproject.toml $(CONSTRAINTS) $(VENV)/.made
	$(call TELL,)
	$(INSTALL) --editable ".[console]"
	@touch $@

# MAVProxy is installed without its dependencies (maps, plots, OpenCV): the tests drive it headless. Of these packages
# most modules are never imported: bytecode is made of the others as they are.
$(VENV)/.installed-test: pyproject.toml $(CONSTRAINTS) $(VENV)/.made
	$(call TELL, and the tools of the tests)
	$(INSTALL) --no-compile --editable ".[test]"
	$(INSTALL) --no-compile --no-deps "MAVProxy==1.8.75"
	@touch $(VENV)/.installed $@

$(VENV)/.installed-docs: pyproject.toml $(CONSTRAINTS) $(VENV)/.made
	$(call TELL, and mkdocs)
	$(INSTALL) --editable ".[console,docs]"
	@touch $(VENV)/.installed $@

clean:
	rm -rf $(VENV) companion/_native out build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
