# Everything happens in a virtual environment that the first target makes: `make help` lists the targets.
# Needed: Python >= 3.11, git, make; uv and a C compiler are used where they are found.

PYTHON ?= python3
VENV ?= .venv
# --editable for work on the sources; empty installs a built wheel
INSTALL ?= --editable
# what and how pytest runs: make test TESTS=tests/unit PYTEST_ARGS="-x -n 0"
TESTS ?=
PYTEST_ARGS ?= -n auto --maxprocesses 4 --dist worksteal
DEMO ?= demo
LOCK_ARGS ?=

.DEFAULT_GOAL := help
SHELL := /bin/sh
MAKEFLAGS += --no-print-directory
.DELETE_ON_ERROR:

# Windows, whose make runs these recipes by the shell of Git, has programs in another folder.
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
PY := $(BIN)/python
UV := $(shell command -v uv 2>/dev/null)
export UV_PYTHON_DOWNLOADS := never
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# Where it is set, every worker and every command of the tests compiles the whole house again.
unexport PYTHONDONTWRITEBYTECODE

# The stamps carry the name of the interpreter, so that another PYTHON makes the environment anew.
space := $(subst ,, )
DEPS := $(VENV)/.deps-$(subst $(space),_,$(subst /,_,$(PYTHON)))
READY := $(VENV)/.ready$(subst $(space),_,$(INSTALL))
DEV := $(VENV)/.dev
EXTRA := $(VENV)/.test
DOCS := $(VENV)/.docs
KERNEL := $(wildcard src/microslip/_core/kernels/*.[ch])
# An editable install sees edits of the Python sources by itself, a built one does not.
SOURCES := $(if $(INSTALL),,$(shell find src/microslip -type f ! -name '*.so' ! -name '*.pyc'))

.PHONY: help install demo test slow attack laboratory record attack-sanitized hosts browser lint format format-check types check bench reference \
    validation notebooks coverage docs dist lock clean \
    distclean

help:  ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## /\1|/p' Makefile | awk -F'|' '{ printf "  %-14s %s\n", $$1, $$2 }'

# Install the packages of one group of requirements.lock, with their hashes checked.
locked = awk -v group=$(1) '/^\# for /{ on = index($$0 " ", " " group " ") } on' requirements.lock >"$(VENV)/$(1).txt" && \
    $(if $(UV),"$(UV)" pip install --quiet --python "$(PY)" --compile-bytecode,"$(PY)" -m pip install --quiet --quiet) \
    --require-hashes -r "$(VENV)/$(1).txt"

# A changed lock makes the environment anew; only a folder that is an environment is ever removed.
$(DEPS): requirements.lock
	@"$(PYTHON)" -c 'import sys' 2>/dev/null || { \
	    echo "error: PYTHON=$(PYTHON) does not run; name one that does, such as: make PYTHON=python3.12" >&2; exit 1; }
	@"$(PYTHON)" -c 'import sys; sys.version_info < (3, 11) and sys.exit(\
	    "error: microslip needs Python 3.11 or newer, PYTHON=$(PYTHON) is %d.%d.%d; " % sys.version_info[:3] \
	    + "name a newer one, such as: make PYTHON=python3.12")'
	@if [ -e "$(VENV)" ] && [ ! -e "$(VENV)/pyvenv.cfg" ]; then \
	    echo "error: VENV=$(VENV) exists and is not a virtual environment; name another folder" >&2; exit 1; fi
	@rm -rf "$(VENV)"
	@echo "Making $(VENV) with the locked packages ($(if $(UV),uv,pip), up to a minute)"
ifneq ($(UV),)
	@"$(UV)" venv --quiet --no-project --python "$$("$(PYTHON)" -c 'import sys; print(sys.executable)')" "$(VENV)"
else
	@"$(PYTHON)" -m venv "$(VENV)"
endif
	@$(call locked,run)
	@touch "$@"

# What an earlier build left must not stand in for an extension that now fails to build.
$(READY): $(DEPS) pyproject.toml setup.py tools/kernel_build.py src/microslip/_version.py $(KERNEL) $(SOURCES)
	@rm -rf build src/microslip/_core/kernels/_compiled*.so src/microslip/_core/kernels/_compiled*.pyd "$(VENV)"/.ready*
	@if [ -n "$$("$(PY)" tools/kernel_build.py)" ]; then \
	    echo "Adding a C compiler (ziglang, 100 MB): there is none here"; \
	    $(call locked,compiler); fi
	@echo "Installing microslip"
ifneq ($(UV),)
	@"$(UV)" pip install --quiet --python "$(PY)" --no-build-isolation --no-deps --reinstall-package microslip $(INSTALL) .
else
	@"$(PY)" -m pip install --quiet --quiet --no-build-isolation --no-deps --force-reinstall $(INSTALL) .
endif
	@"$(PY)" -c "import microslip._core.kernels"
	@touch "$@"

# What work, the tests (with all extras) and the documentation need comes on top; a demo needs none of it.
$(DEV) $(EXTRA) $(DOCS): $(VENV)/.%: $(DEPS) requirements.lock
	@echo "Adding the packages for $*"
	@$(call locked,$*)
	@touch "$@"

install: $(READY)  ## make the environment and install the package into it

demo: $(READY)  ## predict a milled joint and a bolted beam; reports, tables and figures go to demo/
	@mkdir -p "$(DEMO)"
	@"$(BIN)/microslip" predict examples/al2017.toml -o "$(DEMO)/joint" --overwrite
	@echo
	@"$(BIN)/microslip" predict examples/bolted_beam.toml -o "$(DEMO)/beam" --overwrite

test: $(READY) $(EXTRA)  ## run the tests, but for the slow ones
	@"$(PY)" -m pytest $(PYTEST_ARGS) $(TESTS)

slow: $(READY) $(EXTRA)  ## run the slow tests
	@"$(PY)" -m pytest -m slow --durations=40 $(PYTEST_ARGS) $(TESTS) || { \
	    code=$$?; [ $$code -eq 5 ] || exit $$code; echo "There are no slow tests."; }

# make attack INPUTS=1000000 TABLE=docs/attack.md writes the table of the page
INPUTS ?= 20000
TABLE ?=
attack: $(READY) $(EXTRA)  ## attack everything public with generated input
	@cd tests && PYTHONPATH=../benchmarks:. OPENBLAS_NUM_THREADS=1 "$(abspath $(PY))" -m attack --inputs $(INPUTS) \
	    $(if $(TABLE),--table $(abspath $(TABLE)))

laboratory: $(READY) $(DEV)  ## how often intervals hold the truth and what wrong physics passes, into docs/identify.md
	@cd tests && PYTHONPATH=. OPENBLAS_NUM_THREADS=1 "$(abspath $(PY))" -m laboratory --write

record: $(READY) $(EXTRA)  ## predict the published numbers of record/, into docs/record.md
	@OPENBLAS_NUM_THREADS=1 "$(PY)" record/run.py

attack-sanitized: $(READY)  ## the same on a kernel built with sanitizers
	@tools/sanitize.sh "$(abspath $(PY))" --only histories --only states --only varying --inputs $(INPUTS)

# HOSTS="fmu jax" tries some of them; minutes, and it installs each host into an environment that it removes
HOSTS ?=
hosts: $(READY)  ## run the joint in other people's programs (PyPI packages, ccx)
	@tools/try_hosts.sh "$(PYTHON)" $(HOSTS)

browser:  ## explorer, workbench and reports in a real browser (PyPI packages, chromium, node)
	@tools/try_browser.sh "$(PYTHON)"

lint: $(READY) $(DEV)  ## look for mistakes (ruff) and unclear words (tools/check_words.py)
	@"$(PY)" -m ruff check
	@"$(PY)" tools/check_words.py

format: $(READY) $(DEV)  ## format the code, mend what lint can mend
	@"$(PY)" -m ruff check --fix --exit-zero --quiet
	@"$(PY)" -m ruff format

format-check: $(READY) $(DEV)  ## check the format, change nothing
	@"$(PY)" -m ruff format --check

types: $(READY) $(DEV)  ## check the types (mypy, strict)
	@"$(PY)" -m mypy

check: lint format-check types test  ## lint, format, types and tests

bench: $(READY) $(DEV)  ## measure the speed
	@"$(PY)" benchmarks/run.py

reference: $(READY) $(DEV)  ## compute the reference numbers of the tests again (mpmath, slow)
	@"$(PY)" tests/reference/make_reference.py

validation: $(READY) $(EXTRA)  ## compare with everything there is, and write docs/validation.md
	@OPENBLAS_NUM_THREADS=1 "$(PY)" tools/make_validation.py --page

coverage: $(READY) $(EXTRA)  ## run the tests with branch coverage
	@"$(PY)" -m coverage run -m pytest $(TESTS)
	@"$(PY)" -m coverage report

docs: $(READY) $(DOCS)  ## write the reference pages and build the documentation into docs/_build/html/; a warning is an error
	@"$(PY)" docs/make_reference.py
	@"$(PY)" -m sphinx -W -E --keep-going -q -b html docs docs/_build/html
	@echo "docs/_build/html/index.html"

# NOTEBOOKS="01 13" makes these alone
NOTEBOOKS ?=
notebooks: $(READY) $(DOCS)  ## make notebooks of the gallery in notebooks/, each run by Jupyter
	@OPENBLAS_NUM_THREADS=1 "$(PY)" tools/make_notebooks.py notebooks --run $(NOTEBOOKS)

dist: $(READY) $(DEV)  ## build the sdist, and from it the wheel, into dist/
	@rm -rf dist
	@"$(PY)" -m build --no-isolation

# One lock for every Python and platform, read by uv and by pip. LOCK_ARGS=--upgrade takes newer versions.
lock:  ## write requirements.lock again
	@uv="$(UV)"; if [ -z "$$uv" ]; then \
	    [ -x .venv-lock/bin/uv ] || { "$(PYTHON)" -m venv .venv-lock && .venv-lock/bin/python -m pip install --quiet uv; }; \
	    uv=.venv-lock/bin/uv; fi; \
	"$(PYTHON)" tools/lock.py "$$uv" $(LOCK_ARGS)

clean:  ## remove builds, caches and the demo
	@rm -rf build demo dist docs/_build docs/api docs/gallery
	@rm -rf src/*.egg-info src/microslip/_core/kernels/_compiled*.so src/microslip/_core/kernels/_compiled*.pyd .venv*/.ready*
	@rm -rf .coverage .coverage.* .hypothesis .mypy_cache .pytest_cache .ruff_cache htmlcov
	@find benchmarks docs examples src tests tools -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

distclean: clean  ## and the environments
	@for folder in .venv*; do [ ! -e "$$folder/pyvenv.cfg" ] || rm -rf "$$folder"; done
