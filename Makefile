# Works with GNU make and any POSIX shell. `make` alone lists what there is.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check
SETUP  := pyproject.toml constraints.txt

.DEFAULT_GOAL := help
.PHONY: help demo test test-slow test-data site pages package package-test bench recovery coverage faults fuzz incomplete lint style types format pytest lock \
        clean
# Tests start hundreds of processes, each of which would compile the package's modules anew.
unexport PYTHONDONTWRITEBYTECODE

help: ## List these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile

demo: $(VENV)/.installed ## Synthetic bench, full identification, results in demo/
	$(BIN)/mechid demo --out demo

test: lint pytest ## All that CI checks: format, lint, types, layers, tests, doctests

test-slow: $(VENV)/.installed-dev ## The tests marked slow
	$(BIN)/python -m pytest -m slow

test-data: $(VENV)/.installed-data ## The tests on measured data by others (MECHID_DATA=folder), a line a figure
	$(BIN)/python -m pytest -m data

# Each warning is an error: a broken link, a page that no other leads to, a public name without a docstring.
SPHINX := PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python -m sphinx --fail-on-warning --keep-going --fresh-env --quiet

site: $(VENV)/.installed-site ## The documentation as a site, tutorials run: build/site/index.html, no network
	$(SPHINX) -D nb_execution_mode=cache -D nb_execution_cache_path=build/tutorials docs build/site
	@echo "open build/site/index.html"

pages: $(VENV)/.installed-site ## The same with no tutorial run, in seconds: links, formulas, docstrings
	$(SPHINX) docs build/pages

package: $(VENV)/.installed-dev ## Wheel and source archive, in dist/
	rm -rf dist
	$(BIN)/python -m build

package-test: $(VENV)/.installed-dev ## The suite against the wheel in an environment of its own (PYTHON=python3.13 OPTIONS="-x tests/cli")
	rm -rf build/package && mkdir -p build/package
	tar -x -z --strip-components 1 -C build/package -f dist/mechid-*.tar.gz && rm -r build/package/src
	$(PYTHON) -m venv build/package/.venv
	build/package/.venv/bin/python -m pip --disable-pip-version-check install -c constraints.txt "$$(echo dist/mechid-*.whl)[dev]"
	cd build/package && .venv/bin/python -m pytest -o testpaths=tests $(OPTIONS)

bench: $(VENV)/.installed-bench ## Speed side by side with peers, on this machine
	$(BIN)/python benchmarks/bench_sweep.py
	$(BIN)/python benchmarks/bench_sweep.py --avx2 --only mechid "C by hand"

recovery: $(VENV)/.installed ## 100 random mechanisms from the catalogue, resumable (OPTIONS="--family 2 --seeds 0:40")
	$(BIN)/python benchmarks/recovery.py $(OPTIONS)

coverage: $(VENV)/.installed ## Coverage of the 95 % intervals, resumable (OPTIONS="--noise white|ar888|ar46 --draws 0:400")
	$(BIN)/python benchmarks/interval_coverage.py $(OPTIONS)

incomplete: $(VENV)/.installed ## Errors where one effect is left out of the model, resumable (OPTIONS="--seeds 0:5 --halves")
	$(BIN)/python benchmarks/incomplete_benches.py $(OPTIONS)

fuzz: $(VENV)/.installed-dev ## Files and command lines changed by a program, resumable (OPTIONS="--seconds 600 --kinds hdf5,mat")
	$(BIN)/python -m fuzz $(OPTIONS)

faults: $(VENV)/.installed-dev ## Killed, interrupted, starved: each run comes to the same numbers, resumable (OPTIONS="--only kill,full --count 10")
	$(BIN)/python benchmarks/faults.py $(OPTIONS)

lint: style types ## Style, format and types, nothing changed

style: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.installed-dev
	$(BIN)/mypy

pytest: $(VENV)/.installed-dev ## Tests and doctests alone
	$(BIN)/python -m pytest -n auto --maxprocesses 4 --dist loadfile

format: $(VENV)/.installed-dev ## Bring the sources into form
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

lock: ## Write constraints.txt anew from the newest versions that pyproject.toml allows
	rm -rf build/lock
	$(PYTHON) -m venv build/lock
	build/lock/bin/python -m pip --disable-pip-version-check install -e '.[bench,cluster,control,dataframes,dev,formats,office,site,structures]'
	{ echo '# Every version that make installs, by `make lock`; do not edit. What only Windows needs is not pinned.'; \
	  build/lock/bin/python -m pip --disable-pip-version-check freeze --exclude-editable; } > build/constraints.txt
	mv build/constraints.txt constraints.txt
	rm -rf build/lock

clean: ## Remove the demo, build products and tool caches (not .venv)
	rm -rf demo build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find . -path ./$(VENV) -prune -o -name __pycache__ -type d -prune -exec rm -rf {} +

# The private environment: a stamp per set of packages, older than its recipe's inputs when stale.

$(VENV)/.created:
	@$(PYTHON) -c 'import sys; v = sys.version.split()[0]; sys.exit(0 if sys.version_info >= (3, 11) \
	  else "mechid needs Python 3.11 or newer, $(PYTHON) is " + v + "; try: make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv $(VENV)
	@touch $@

$(VENV)/.installed: $(SETUP) | $(VENV)/.created
	$(PIP) install -c constraints.txt -e .
	@touch $@

$(VENV)/.installed-dev: $(SETUP) | $(VENV)/.created
	$(PIP) install -c constraints.txt -e '.[dev]'
	@touch $@ $(VENV)/.installed

$(VENV)/.installed-data: $(SETUP) | $(VENV)/.created
	$(PIP) install -c constraints.txt -e '.[dev,structures]'
	@touch $@ $(VENV)/.installed $(VENV)/.installed-dev

$(VENV)/.installed-bench: $(SETUP) | $(VENV)/.created
	$(PIP) install -c constraints.txt -e '.[bench]'
	@touch $@ $(VENV)/.installed

$(VENV)/.installed-site: $(SETUP) | $(VENV)/.created
	$(PIP) install -c constraints.txt -e '.[site]'
	@touch $@ $(VENV)/.installed
