# Given: make, a POSIX shell and Python 3.11 or newer. Everything else is fetched into .venv.
# Another interpreter:   make PYTHON=python3.12 demo     (after `make clean`, if .venv was made with another one)

PYTHON = python3
VENV = .venv
BIN = $(VENV)/bin
PIP = $(BIN)/python -m pip --disable-pip-version-check install --quiet -c constraints.txt
DEMO = runs/demo

.PHONY: help demo test browser lint cover clean

help:
	@echo "make demo    install into $(VENV), fly one lawnmower, print the summary, name the picture"
	@echo "make test    all checks and all tests"
	@echo "make lint    style, types and the direction of imports"
	@echo "make cover   coverage of the cores, with the lines that are missed; fails below 95 %"
	@echo "make clean   remove $(VENV), $(DEMO) and caches"
	@echo "make PYTHON=python3.12 ...   with another interpreter"

demo: $(VENV)/installed
	$(BIN)/grex run deploy/scenarios/paper-d.toml --out $(DEMO)
	@test -s $(DEMO)/run.png
	@echo "picture $(DEMO)/run.png"

# The processes come last and alone: they measure wall time, and two cores are busy with one team.
test: lint browser
	$(BIN)/pytest -n 2 --dist worksteal --ignore=tests/processes --ignore=tests/browser --ignore=tests/benchmarks --cov
	$(BIN)/pytest tests/processes tests/browser

# Debian's own; who is not root is told, and the tests that need it are skipped.
browser:
	@command -v chromium >/dev/null || if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
	    echo "installing Chromium for the tests of the page"; \
	    { apt-get update -qq && apt-get install -qq -y --no-install-recommends chromium fonts-dejavu-core; } \
	        >/dev/null 2>&1 || echo "Chromium could not be installed: the tests of the page are skipped" >&2; \
	else echo "no Chromium: the tests of the page are skipped; apt-get install chromium" >&2; fi

lint: $(VENV)/installed-dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports

cover: $(VENV)/installed-dev
	$(BIN)/pytest -n 2 --dist worksteal --ignore=tests/processes --ignore=tests/browser --ignore=tests/benchmarks --cov

$(VENV)/installed-dev: $(VENV)/installed
	@echo "installing what the checks need into $(VENV)"
	$(PIP) -e '.[dev,view,foxglove]'
	@touch $@

$(VENV)/installed: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	    echo "GREX needs Python 3.11 or newer, and $(PYTHON) is none: make PYTHON=python3.12 ..." >&2; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
	    echo "$(PYTHON) cannot make environments: install its venv module (python3-venv)" >&2; exit 1; }
	@echo "installing GREX and what it needs into $(VENV); the first time this takes a minute or two"
	$(PIP) -e .
	@touch $@

clean:
	rm -rf $(VENV) $(DEMO) build dist *.egg-info .coverage .coverage.*
	rm -rf .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find grex_agent grex_link grex_sim tests -name __pycache__ -type d -prune -exec rm -rf {} +
