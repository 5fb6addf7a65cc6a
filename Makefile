# Three commands on a fresh machine with python3 (3.11 or newer), pip and make:
#   make studio  a page in the browser: draw a path on the ground and somebody walks it
#   make demo    a walk along a drawn path, from recordings that are fetched once
#   make test    the whole suite
# For those who work on it: make docs, make lint, make format, make bench, make mutants, make pictures, make page,
# make dist, make check-dist, make check-clients, make extension, make clean.

PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
BLENDER ?= .venv-blender
MADE   := $(VENV)/.made
STAMP  := $(VENV)/.installed
PLAIN  := $(VENV)/.installed-plain
DOCS   := $(VENV)/.installed-docs
BUILD  := $(VENV)/.installed-build
STUDIO := src/kinetograph/studio
CHECK  := build/check-dist
DEMO   ?= out

.PHONY: studio demo test lint page format bench mutants docs pictures dist check-dist check-clients extension clean help

help:
	@sed -n '1,6p' $(firstword $(MAKEFILE_LIST)) | sed 's/^# //'

$(MADE):
	@command -v $(PYTHON) >/dev/null || { echo "missing: $(PYTHON); install Python 3.11 or newer, or set PYTHON=..." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "too old: $$($(PYTHON) --version); Python 3.11 or newer is needed, set PYTHON=..." >&2; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || { echo "missing: the venv module of $(PYTHON); install it (on Debian: apt-get install python3-venv)" >&2; exit 1; }
	@echo "making $(VENV)"
	@$(PYTHON) -m venv $(VENV)
	@touch $@

# what the studio and the demo need, which is installed sooner than what the tests need
$(PLAIN): pyproject.toml | $(MADE)
	@echo "installing into $(VENV)"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[studio]' || { echo "pip could not install the dependencies; is there a network?" >&2; exit 1; }
	@touch $@

$(STAMP): pyproject.toml | $(MADE)
	@echo "installing into $(VENV)"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev]' || { echo "pip could not install the dependencies; is there a network?" >&2; exit 1; }
	@touch $(PLAIN) $@

# Node of the PATH builds the page and checks its types, or else a wheel of Node
page: $(PLAIN)
	@$(BIN)/python hatch_build.py build

studio: page
	@$(BIN)/kinetograph studio

demo: $(PLAIN)
	@$(BIN)/kinetograph data fetch deepmimic-clips
	@$(BIN)/kinetograph demo -o $(DEMO)

test: $(STAMP)
	@$(BIN)/kinetograph data fetch deepmimic-clips || echo "without the sample, tests of real clips are skipped"
	@$(BIN)/python hatch_build.py build || echo "without the studio's page, its tests are skipped"
	@$(BIN)/python -m pytest

lint: $(STAMP)
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/mypy
	@$(BIN)/python hatch_build.py check

format: $(STAMP)
	@$(BIN)/ruff check --fix
	@$(BIN)/ruff format

bench: $(STAMP)
	@$(BIN)/python -m benchmarks

# small faults are put into the package, one at a time: the share that the tests notice
mutants: $(STAMP)
	@$(BIN)/python -m tests.mutants

$(DOCS): $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[docs]'
	@touch $@

docs: $(DOCS)
	@$(BIN)/kinetograph data fetch deepmimic-clips
	@$(BIN)/python docs/_ext/docstrings.py
	@$(BIN)/python -m sphinx -q -W -n -b html -d docs/_build/doctrees docs docs/_build/html
	@echo "open docs/_build/html/index.html"

pictures: $(STAMP)
	@$(BIN)/kinetograph data fetch deepmimic-clips
	@$(BIN)/kinetograph data fetch character
	@$(BIN)/python docs/pictures.py
	@$(BIN)/python docs/studio_picture.py

$(BUILD): $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check build
	@touch $@

dist: $(BUILD)
	@rm -rf dist
	@$(BIN)/python -m build --outdir dist

# the wheel into a bare environment, its page and its demo; the suite from the unpacked sdist, without further recordings
check-dist: dist
	@rm -rf $(CHECK) && mkdir -p $(CHECK)
	@$(PYTHON) -m venv $(CHECK)/bare
	@$(CHECK)/bare/bin/python -m pip install --quiet --disable-pip-version-check dist/*.whl
	@cd $(CHECK) && bare/bin/python -c 'from kinetograph.studio.page import page_folder; print("the page is in", page_folder())'
	@cd $(CHECK) && bare/bin/kinetograph data fetch deepmimic-clips && bare/bin/kinetograph demo -o demo
	@tar -xzf dist/*.tar.gz -C $(CHECK) --one-top-level=sdist --strip-components=1
	@$(PYTHON) -m venv $(CHECK)/suite
	@cd $(CHECK)/sdist && ../suite/bin/python -m pip install --quiet --disable-pip-version-check -e '.[dev]'
	@cd $(CHECK)/sdist && env -u KINETOGRAPH_DATA CI=true ../suite/bin/python -m pytest -x -q

# Blender's extension, always the same bytes
extension: $(MADE)
	@$(BIN)/python blender/build.py dist

check-clients: $(STAMP)
	@command -v npm >/dev/null || { echo "missing: npm, which installs the glTF validator and three.js" >&2; exit 1; }
	@cd tests/clients && npm ci --silent --no-fund --no-audit
	@test -x $(BLENDER)/bin/python || { $(PYTHON) -m venv $(BLENDER) && $(BLENDER)/bin/pip install --quiet bpy==5.0.1; } || echo "without bpy 5.0.1 Blender's checks are skipped"
	@$(BIN)/kinetograph data fetch deepmimic-clips
	@$(BIN)/kinetograph data fetch character
	@$(BIN)/python tests/clients/check.py --blender $(BLENDER)/bin/python
	@$(BIN)/python tests/clients/extension.py --blender $(BLENDER)/bin/python
	@if test -d "$(VMC4B)"; then $(BIN)/python tests/clients/vmc.py --blender $(BLENDER)/bin/python --receiver $(VMC4B); else echo "without VMC4B=FOLDER, a checkout of that add-on, VMC is not checked in Blender"; fi

clean:
	rm -rf $(STUDIO)/page $(STUDIO)/client/node_modules
	rm -rf $(VENV) $(DEMO) dist build docs/_build docs/api docs/gallery docs/cli.md .pytest_cache .mypy_cache .ruff_cache .hypothesis
