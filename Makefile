# The parts of `.ci/run`, one at a time, in the environment that README.md's test command makes.
# `make` says what there is; `make test T=tests/bus` runs a part of the tests.

BIN := .venv/bin
T ?= tests
N ?= auto
P ?=
PAGE := lbr/apps/web/page

.PHONY: help setup check lint format types docs prose names site test coverage nightly gate smoke page pagecheck all

help: ## say what there is
	@grep -hE '^[a-z]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## /\1\t/' | expand -t 12

setup: ## make the environment, or bring it up to date
	python3 -m venv .venv
	$(BIN)/pip install -q -e '.[sim,dev]'

check: lint types docs ## what takes a minute: lint, types, generated pages, floors
	$(BIN)/pytest tests/test_architecture.py

lint: ## ruff, nothing changed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

format: ## ruff, what it can mend
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

types: ## mypy: lbr, examples, and what 'lbr new' writes
	$(BIN)/mypy
	MYPYPATH=examples/so101 $(BIN)/mypy -p lbr_so101
	MYPYPATH=examples/roboclaw $(BIN)/mypy -p lbr_roboclaw
	$(BIN)/pytest -q -m "nightly or not nightly" tests/commands/test_new.py::test_they_pass_the_checks_that_lbr_passes

docs: ## are the generated pages true, and has no page or package become harder to read?
	$(BIN)/python docs/generate.py --check
	$(BIN)/python docs/prose.py --check
	$(BIN)/python docs/names.py --check

prose: ## sentences that are hard to read: all pages and packages, or those of P=docs/web.md
	$(BIN)/python docs/prose.py $(P)

names: ## names that say nothing of the domain, by package, or those of P=lbr/drivers
	$(BIN)/python docs/names.py $(P)

site: ## the docs as a site, in build/site/index.html
	$(BIN)/python docs/site/build.py

test: ## the tests of every day, or those under T=path, N at a time
	$(BIN)/pytest -n $(N) --dist worksteal $(T)

nightly: ## all tests, with many examples and what takes minutes, root or a network; the gate and every benchmark
	$(BIN)/pytest -n $(N) --dist worksteal -m "nightly or not nightly" --hypothesis-profile nightly
	$(MAKE) --no-print-directory gate smoke

coverage: ## the tests, and what of the code their own processes run; what whole robots run beside them is not counted
	$(BIN)/pytest -n $(N) --cov --cov-report=term $(T)

gate: ## the safety gate: a small amount of each measurement
	$(BIN)/python -m benchmarks safety --gate

smoke: ## does every benchmark still work? seconds of each
	$(BIN)/python -m benchmarks --smoke

page: ## test and build the page that the robot serves, with node 20.19 or newer; commit what it writes to dist/
	cd $(PAGE) && npm ci --no-audit --no-fund && npm test && npm run build

pagecheck: ## is the page that is committed what its sources build to?
	@before=$$(mktemp -d) && cp -r $(PAGE)/dist $$before && $(MAKE) --no-print-directory page && diff -r $$before/dist $(PAGE)/dist && rm -r $$before

all: ## the check of every change, as on a machine that has next to nothing
	.ci/run
