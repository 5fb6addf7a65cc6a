# Two commands on a fresh machine with python3 (3.11 or newer), pip and make:
#   make demo    a walk along a drawn path, from recordings that are fetched once
#   make test    the whole suite
# For those who work on it: make lint, make bench, make docs, make check-clients, make clean.

PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
BLENDER ?= .venv-blender
STAMP  := $(VENV)/.installed
DEMO   ?= out

.PHONY: demo test lint format bench docs check-clients clean help

help:
	@sed -n '1,4p' $(firstword $(MAKEFILE_LIST)) | sed 's/^# //'

$(STAMP): pyproject.toml
	@command -v $(PYTHON) >/dev/null || { echo "missing: $(PYTHON); install Python 3.11 or newer, or set PYTHON=..." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "too old: $$($(PYTHON) --version); Python 3.11 or newer is needed, set PYTHON=..." >&2; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || { echo "missing: the venv module of $(PYTHON); install it (on Debian: apt-get install python3-venv)" >&2; exit 1; }
	@echo "installing into $(VENV)"
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev]' || { echo "pip could not install the dependencies; is there a network?" >&2; exit 1; }
	@touch $@

demo: $(STAMP)
	@$(BIN)/kinetograph data fetch deepmimic-clips
	@$(BIN)/kinetograph demo -o $(DEMO)

test: $(STAMP)
	@$(BIN)/kinetograph data fetch deepmimic-clips || echo "without the sample, tests of real clips are skipped"
	@$(BIN)/python -m pytest

lint: $(STAMP)
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/mypy

format: $(STAMP)
	@$(BIN)/ruff check --fix
	@$(BIN)/ruff format

bench: $(STAMP)
	@$(BIN)/python -m benchmarks

docs: $(STAMP)
	@$(BIN)/python docs/build.py

check-clients: $(STAMP)
	@command -v npm >/dev/null || { echo "missing: npm, which installs the glTF validator and three.js" >&2; exit 1; }
	@cd tests/clients && npm ci --silent --no-fund --no-audit
	@test -x $(BLENDER)/bin/python || { $(PYTHON) -m venv $(BLENDER) && $(BLENDER)/bin/pip install --quiet bpy==5.0.1; } || echo "without bpy 5.0.1 Blender's checks are skipped"
	@$(BIN)/kinetograph data fetch deepmimic-clips
	@$(BIN)/kinetograph data fetch character
	@$(BIN)/python tests/clients/check.py --blender $(BLENDER)/bin/python

clean:
	rm -rf $(VENV) $(DEMO) .pytest_cache .mypy_cache .ruff_cache .hypothesis
