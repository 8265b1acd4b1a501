# `make` lists the verbs. Everything is installed into .venv from constraints.txt.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
DEMO   := demo

.PHONY: help setup demo test test-slow lint types floors schema docs docs-check messages bench wheel clean

help: ## this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 14

setup: $(STAMP) ## make .venv with orient and its tools

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "orient needs Python 3.11 or newer; try: make PYTHON=python3.11 ...")'
	@echo 'Setting up $(VENV); the first time this takes about a minute.'
	@$(PYTHON) -m venv --clear $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[dev]"
	@touch $@

demo: $(STAMP) ## orient a real space photograph, Apollo 15 from lunar orbit
	@BIN=$(BIN) DEMO=$(DEMO) sh sample_projects/demo.sh

test: $(STAMP) ## all tests but the slow ones
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "not slow"

test-slow: $(STAMP) ## long simulations and fault loops; prints the table of promises
	$(BIN)/python -m pytest -n 2 -m "slow or promise" --promises build/promises.md

lint: $(STAMP) ## ruff
	$(BIN)/ruff check . && $(BIN)/ruff format --check .

types: $(STAMP) ## mypy, strict
	$(BIN)/mypy

floors: $(STAMP) ## import contracts
	$(BIN)/lint-imports

schema: $(STAMP) ## write 0003_evidence.sql and schema.json from models.py, guards.sql, views.sql
	$(BIN)/python -m orient.store.schema_files

docs: $(STAMP) ## write docs/cli.md, docs/schema.md, docs/summary.md from the code
	$(BIN)/python -m orient.cli.reference docs

docs-check: $(STAMP) ## fail if the generated pages are not up to date
	$(BIN)/python -m orient.cli.reference docs --check

messages: $(STAMP) ## bring the catalogues of the report's languages up to date
	$(BIN)/python -m orient.report.catalogues

bench: $(STAMP) ## speed as ratios to other libraries (a quarter of an hour): docs/performance.md and its figure
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[fast,bench]"
	$(BIN)/python -m benchmarks

wheel: $(STAMP) ## build dist/orient-*.whl
	$(BIN)/python -m build --wheel --outdir dist .

clean: ## remove what make made
	rm -rf $(VENV) $(DEMO) dist build
