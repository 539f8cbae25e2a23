# Needs only make and Python 3.11 or newer (with venv). Everything is installed into .venv; nothing outside this folder is touched.

PYTHON ?= python3
VENV := .venv
PY := $(VENV)/bin/python
PIP := $(PY) -m pip --disable-pip-version-check install --quiet

ARGS ?=# more options for walking-console, e.g. make run ARGS="--port 9000"
BROWSER_TESTS = tests/web# where they all are, so that no others are read for them
PYTEST_ARGS ?=# more options for pytest, e.g. make test PYTEST_ARGS="-k layers"
JOBS ?= logical# processes the tests run in, but those in a browser: theirs come after, one by one

# The four rooms under their one import name, as plain folders: what editors, mypy and other tools that do not run Python follow.
SOURCE := $(VENV)/source/walking_console
LINK = mkdir -p $(SOURCE) && for part in planner sim server web; do ln -sfn ../../../$$part $(SOURCE)/$$part; done \
	&& for part in walking_console/*.py walking_console/py.typed; do ln -sfn ../../../$$part $(SOURCE)/$$(basename $$part); done \
	&& $(PY) -c 'import sysconfig, pathlib; pathlib.Path(sysconfig.get_path("purelib"), "walking-console-source.pth").write_text(str(pathlib.Path("$(VENV)/source").resolve()) + "\n")'

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help run test test-pythons test-lowest lint-page bench clean

help:
	@echo 'make run     start the console and open its page   (ARGS="--port 9000 --scenario river")'
	@echo 'make test    check style and types, then run all tests   (PYTEST_ARGS="-k layers")'
	@echo 'make test-pythons  walk the recorded walks and run all tests on other Pythons   (PYTHONS="python3.12 python3.13")'
	@echo 'make test-lowest  try the oldest versions of everything that pyproject.toml allows'
	@echo 'make lint-page  check the scripts of the page (with npm)'
	@echo 'make bench   measure planner, tick and headless speed on this machine'
	@echo 'make clean   remove the environment and what builds and checks left behind'

run: $(VENV)/.installed
	$(VENV)/bin/walking-console serve $(ARGS)

bench: $(VENV)/.installed
	$(VENV)/bin/walking-console bench $(ARGS)

test: $(VENV)/.installed-for-tests
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy
	@$(MAKE) --no-print-directory lint-page
	$(PY) -m pytest -n $(JOBS) --dist worksteal -m "not browser" $(PYTEST_ARGS)
	@$(PY) -m pytest -m browser $(BROWSER_TESTS) $(PYTEST_ARGS) || [ $$? = 5 ]

# Every other Python gets an environment of its own, .venv-3.12 and so on; the recorded walks are the first thing it has to repeat.
PYTHONS ?= python3.12 python3.13

test-pythons:
	@for python in $(PYTHONS); do \
		version=$$($$python -c 'import sys; print("%d.%d" % sys.version_info[:2])') || exit 1; \
		echo "Python $$version:"; \
		$(MAKE) --no-print-directory VENV=.venv-$$version PYTHON=$$python .venv-$$version/.installed-for-tests || exit 1; \
		.venv-$$version/bin/python -m tests.corpus.walks check || exit 1; \
		.venv-$$version/bin/python -m pytest -p no:cacheprovider --ignore=tests/walks/test_corpus.py \
			-n $(JOBS) --dist worksteal -m "not browser" $(PYTEST_ARGS) || exit 1; \
		.venv-$$version/bin/python -m pytest -p no:cacheprovider -m browser $(BROWSER_TESTS) $(PYTEST_ARGS) || [ $$? = 5 ] || exit 1; \
	done

# The scripts of the page: eslint, and their JSDoc types by tsc. Node 20 or newer with npm does it; it is needed for nothing else.
lint-page:
	@if ! command -v npm > /dev/null || ! command -v node > /dev/null; then \
		echo "npm is not here: the scripts of the page are not checked"; \
	elif ! node -e 'process.exit(parseInt(process.versions.node) < 20 ? 1 : 0)'; then \
		echo "node $$(node -v) is too old: the scripts of the page are not checked"; \
	elif ! [ node_modules/.package-lock.json -nt package-lock.json ] && ! npm ci --silent; then \
		echo "npm could not install its tools: the scripts of the page are not checked"; \
	else \
		npm run --silent lint && echo "The scripts of the page pass eslint and tsc."; \
	fi

# The oldest versions are older than our warnings are strict: they are shown, not taken for errors.
LOWEST := .venv-lowest
LOWEST_TESTS := tests/sim tests/server tests/web tests/test_examples.py

test-lowest:
	@$(PYTHON) -m venv --clear $(LOWEST)
	@$(LOWEST)/bin/python -m pip --disable-pip-version-check install --quiet -c constraints-lowest.txt -e '.[figures,mcap]' \
		'click>=8.2' httpx hypothesis packaging playwright psutil pytest 'setuptools>=77'
	$(LOWEST)/bin/python -m pytest -W default -p no:cacheprovider -m 'not slow and not browser' $(PYTEST_ARGS) $(LOWEST_TESTS)

clean:
	rm -rf $(VENV) .venv-3.* $(LOWEST) node_modules build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find planner sim server web walking_console tests -name __pycache__ -type d -prune -exec rm -rf {} +

# The two stamps are older than pyproject.toml or constraints.txt exactly when the environment has to be brought up to date.
$(VENV)/.installed: pyproject.toml constraints.txt | $(PY)
	@echo "Installing walking-console into $(VENV) ..."
	@$(PIP) -c constraints.txt -e '.[physics]'
	@$(LINK)
	@touch $@

$(VENV)/.installed-for-tests: pyproject.toml constraints.txt | $(PY)
	@echo "Installing walking-console and its test tools into $(VENV) ..."
	@$(PIP) -c constraints.txt -e '.[test]'
	@$(LINK)
	@touch $@ $(VENV)/.installed

$(PY):
	@command -v $(PYTHON) > /dev/null || { echo "No $(PYTHON) here: install Python 3.11 or newer, or name yours: make run PYTHON=/path/to/python3"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "$(PYTHON) is $$($(PYTHON) -V 2>&1): Python 3.11 or newer is needed; name another with make run PYTHON=python3.12"; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2> /dev/null || { echo "$(PYTHON) has no venv module: install it (Debian and Ubuntu: apt install python3-venv) and try again"; exit 1; }
	$(PYTHON) -m venv $(VENV)
