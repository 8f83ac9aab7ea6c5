# make run      a simulated ReVolt for any ground station on this machine; Ctrl-C ends it
# make test     everything that CI runs
# make bench    figures of speed; nothing is asserted
# make scenarios  every scenario over many seeds (long)
# Each sets up its own virtual environment in .venv.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: run test lint bench scenarios clean

run: $(VENV)/.installed
	@$(BIN)/companion run revolt --sitl $(ARGS)

test: lint
	$(BIN)/python -m pytest -n 2 -m "not sweep"

lint: $(VENV)/.installed-test
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/.installed-test
	$(BIN)/python -m tests.bench

scenarios: $(VENV)/.installed-test
	$(BIN)/python -m pytest -n 2 -m sweep tests

# A stamp, since bin/python is a link to a file as old as the machine's Python.
$(VENV)/.made: .ci/make_venv.py
	$(PYTHON) .ci/make_venv.py $(VENV)
	@touch $@

$(VENV)/.installed: pyproject.toml $(VENV)/.made
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

# MAVProxy is installed without its dependencies (maps, plots, OpenCV): the tests drive it headless.
$(VENV)/.installed-test: pyproject.toml $(VENV)/.made
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[test]"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps "MAVProxy==1.8.75"
	@touch $(VENV)/.installed $@

clean:
	rm -rf $(VENV) out build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
