# Telemotion. `make run` and `make test` need Python 3.11+, Node 20.19+ and make; everything else they set up.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# A file's tests stay together: they share a running server.
TWO_AT_ONCE := -n 2 --dist loadfile
QUICK := not slow and not e2e and not postgres
PORT ?= 8000
# Bytecode is kept, also where the surroundings forbid it: each process of the service and the tests starts faster.
export PYTHONDONTWRITEBYTECODE :=
# One thread a process for linear algebra: the service scales over sessions, not inside one.
export OPENBLAS_NUM_THREADS ?= 1

# Says how long a stage of `make run` took since its beginning; says nothing elsewhere.
ready = @$(if $(STARTED_S),echo "$(1) ready after $$(($$(date +%s) - $(STARTED_S))) s")

.PHONY: help run run-scaled test test-quick test-costs coverage checks lint types web web-test api-test bench-live bench-cues bench-pages bench-returns bench-abuse bench-kills bench-scaled bench-kernels bench-gait bench-magnetic bench-viewer validate accuracy docs lock wheel try-wheel check-versions browser clean

help: ## This list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | awk 'BEGIN {FS = ":.*## "} {printf "  make %-14s %s\n", $$1, $$2}'

check-versions:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Python 3.11 or newer is needed; call make PYTHON=/path/to/python3.11"; exit 1; }

$(VENV)/installed: requirements.lock pyproject.toml
	@$(MAKE) --no-print-directory check-versions
	@echo "Setting up Python packages (half a minute the first time) ..."
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@
	$(call ready,Python packages)

# What edges and workers need besides; the service in one process does without.
$(VENV)/scaled: $(VENV)/installed requirements-scaled.lock
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --no-deps -r requirements-scaled.lock
	@touch $@

# What builds the documentation site; the service and its tests do without.
$(VENV)/docs: $(VENV)/installed requirements-docs.lock
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-docs.lock
	@touch $@

# Kernels are compiled when they are first called. Tests need nearly all of them: here once, on two cores.
KERNELS := $(shell find estimators published -name '*.py' 2>/dev/null)
$(VENV)/compiled: $(VENV)/scaled $(KERNELS)
	@echo "Compiling the numerical kernels (some minutes the first time) ..."
	@$(BIN)/telemotion compile --processes 2
	@touch $@

web/node_modules/installed: web/package-lock.json
	@command -v node >/dev/null || { echo "Node 20.19 or newer is needed to build the browser client"; exit 1; }
	@node -e 'const [a, b] = process.versions.node.split(".").map(Number); process.exit(a > 20 || (a === 20 && b >= 19) ? 0 : 1)' \
		|| { echo "Node 20.19 or newer is needed; this is $$(node --version)"; exit 1; }
	@echo "Setting up browser client packages ..."
	@cd web && npm ci --silent --no-audit --no-fund
	@touch $@

WEB_SOURCES := $(shell find web/src web/public web/index.html web/vite.config.ts messages/*.json -type f 2>/dev/null)
web/dist/index.html: web/node_modules/installed $(WEB_SOURCES)
	@echo "Building the browser client ..."
	@cd web && npm run --silent build
	$(call ready,Browser client)

web: web/dist/index.html ## Build the browser client

run: STARTED_S := $(shell date +%s)
run: ## Start the service with a demonstration clinic and a simulated patient
	@$(MAKE) --no-print-directory -j2 $(VENV)/installed web/dist/index.html STARTED_S=$(STARTED_S)
	@$(BIN)/telemotion demo --port $(PORT) --started-s $(STARTED_S)

run-scaled: $(VENV)/scaled web/dist/index.html ## The demonstration on NATS, PostgreSQL, two edges and two workers
	@$(BIN)/telemotion demo-scaled --port $(PORT)

browser: ## Install Debian's Chromium when it is absent and this is root
	@if command -v chromium >/dev/null || [ -n "$$CHROMIUM" ]; then :; \
	elif [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
		echo "Installing Chromium for the browser tests ..."; \
		apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium fonts-dejavu-core >/dev/null; \
	else echo "Chromium is needed for the browser tests: install it, or set CHROMIUM to its path"; exit 1; fi

lint: $(VENV)/installed
	@$(BIN)/ruff check . && $(BIN)/ruff format --check .

types: $(VENV)/scaled
	@$(BIN)/mypy

web-test: web/node_modules/installed
	@cd web && npm run --silent check && npm test --silent

api-test: $(VENV)/installed web/node_modules/installed
	@cd web && npm run --silent api:check

# What needs no Python first: it runs while the packages come.
checks: web-test lint types api-test web/dist/index.html browser

# Many tests wait: for a server that starts, a stream, a page. So those in a browser run beside the others, on their own
# files: another run as root makes the folder of the first one its own, and no PostgreSQL gets in any more.
SERVICE_TESTS := --ignore=tests/e2e -o cache_dir=build/tests/service
# One browser at a time: with a fourth process of tests, others fail by load.
BROWSER_TESTS := tests/e2e -n 1 -o cache_dir=build/tests/browser --basetemp=build/tests/files

# What failed beside others runs again, alone, and that decides; tests that tests/again.txt does not list are named.
# With TELEMOTION_LISTED_ONLY only listed ones run again. Any other end than failed tests stays.
decided = { [ $(1) = 0 ] || { [ $(1) = 1 ] && echo "Failed beside others; alone:" && \
	$(BIN)/python -m pytest $(2) -n 0 -vv -p tests.again --last-failed --last-failed-no-failures none --maxfail=1; }; }

test: ## Everything: lint, types, browser client, unit, service, database and browser tests
	@# The longest first: compiling begins as soon as the packages are there, files with slow tests before the others.
	@$(MAKE) --no-print-directory -j2 $(VENV)/compiled checks
	@rm -rf build/tests; mkdir -p build/tests; echo "What the browser tests say stands in build/tests/browser.log until they have ended."
	@$(BIN)/python -m pytest $(BROWSER_TESTS) -p tests.costs --durations=15 >build/tests/browser.log 2>&1 & browser=$$!; \
	trap 'kill $$browser 2>/dev/null' EXIT; service=0; pages=0; \
	$(BIN)/python -m pytest $(SERVICE_TESTS) $(TWO_AT_ONCE) --no-loadscope-reorder -p tests.costs --durations=15 || service=$$?; \
	wait $$browser || pages=$$?; cat build/tests/browser.log; \
	$(call decided,$$service,$(SERVICE_TESTS)) && $(call decided,$$pages,$(BROWSER_TESTS))

# Apart from `make test`: following every branch makes the tests take three quarters longer.
coverage: $(VENV)/compiled ## Branches that the tests reach, without the browser
	@$(BIN)/python -m pytest -m "not e2e" $(TWO_AT_ONCE) --no-loadscope-reorder --cov --cov-report=term:skip-covered

test-quick: $(VENV)/compiled ## The quick tests only, no browser: at every save; names those that took over 2 s
	@$(BIN)/python -m pytest -m "$(QUICK)" $(TWO_AT_ONCE) -p tests.costs --durations=20 --durations-min=2

test-costs: $(VENV)/compiled ## Processor time of each test that is not marked slow; writes tests/slow.txt and tests/budget.txt
	@$(BIN)/python -m pytest -m "$(QUICK)" $(TWO_AT_ONCE) -p tests.costs --write-slow

bench-live: $(VENV)/installed ## 50 live sessions of 17 sensors at 100 Hz; prints latency and load
	@$(BIN)/python -m tests.benchmarks.bench_live

bench-cues: $(VENV)/installed ## 10 guided sessions with faults; prints the time from packet to cue
	@$(BIN)/python -m tests.benchmarks.bench_cues

bench-pages: $(VENV)/installed web/dist/index.html browser ## Script of the exercise page on a slow phone, and how soon the patient's first page can be used
	@$(BIN)/python -m tests.benchmarks.bench_pages

bench-returns: $(VENV)/installed web/dist/index.html browser ## How soon a live page is right again: restart, pause, cut; 10 s asked
	@RETURNS=3 PAUSE_S=60 WITHIN_S=10 $(BIN)/python -m pytest -s tests/e2e/live/test_live_returns.py

bench-abuse: $(VENV)/installed ## One account takes all it can; prints what its neighbours notice
	@$(BIN)/python -m tests.benchmarks.bench_abuse

bench-kills: $(VENV)/compiled ## Upgrade workers and edges, then kill them, NATS and PostgreSQL again and again; SESSIONS=6
	@$(BIN)/python -m tests.benchmarks.scaled.kills --sessions $(or $(SESSIONS),6)

bench-scaled: $(VENV)/compiled ## Processor cost of a live session in edge, broker, worker and database, and in one process
	@$(BIN)/python -m tests.benchmarks.scaled.costs

bench-kernels: $(VENV)/installed ## Orientation kernels beside the vqf package, kinematics, smoother
	@status=0; for part in kernels kinematics smoother; do $(BIN)/python -m tests.benchmarks.estimation.bench_$$part || status=1; done; exit $$status

bench-gait: $(VENV)/installed ## Cost of following feet: off-line by length, live by sensors
	@$(BIN)/python -m tests.benchmarks.estimation.bench_gait

bench-magnetic: $(VENV)/installed ## Fields a second, and a core's share of a relative-pose session
	@$(BIN)/python -m tests.benchmarks.estimation.bench_magnetic

bench-viewer: $(VENV)/installed ## Processor cost of the 3D scene
	@$(BIN)/python -m tests.benchmarks.bench_viewer

validate: $(VENV)/installed ## Published experiments, ours beside theirs
	@$(BIN)/telemotion validate

accuracy: $(VENV)/installed ## Measure the accuracy page and docs/accuracy.md anew; DATA=folder of recordings
	@$(BIN)/telemotion validate --seeds 50 --processes 2 --data $(DATA) --out app/accuracy/report.json --page docs/accuracy.md

docs: $(VENV)/docs ## Build the documentation site into build/docs; a warning is an error
	@$(BIN)/python -m sphinx -b html -c docs/_site -W --keep-going -n -q -d build/doctrees docs build/docs
	@echo "The site begins at build/docs/index.html"

lock: ## Rewrite the lock files from pyproject.toml (needs uv)
	uv pip compile --quiet --universal --generate-hashes --no-strip-extras --no-header --extra test --python-version 3.11 pyproject.toml -o requirements.lock
	uv pip compile --quiet --universal --generate-hashes --no-strip-extras --no-header --no-annotate --constraint requirements.lock --python-version 3.11 pyproject.toml -o requirements-service.lock
	grep -oE '"(nats|paho)-[a-z-]+==[0-9.]+"' pyproject.toml | tr -d '"' | uv pip compile --quiet --universal --generate-hashes --no-deps --no-header --no-annotate - -o requirements-scaled.lock
	$(PYTHON) -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["docs"], sep="\n")' \
		| uv pip compile --quiet --universal --generate-hashes --no-strip-extras --no-header --no-annotate --constraint requirements.lock --python-version 3.11 - -o requirements-docs.lock

wheel: $(VENV)/scaled web/dist/index.html ## Build a wheel that carries the browser client and the compiled kernels
	@rm -rf app/static && cp -r web/dist app/static
	@$(BIN)/telemotion compile --processes 2 --into estimators/_compiled
	@$(BIN)/python -m pip wheel --quiet --no-deps --no-build-isolation -w dist .
	@# In the tree they would be taken instead of those that an edit compiles.
	@rm -rf estimators/_compiled

try-wheel: wheel ## Install the wheel into an empty environment and start its demonstration there
	@$(BIN)/python tests/notebook/try_wheel.py $$(ls -t dist/*.whl | head -1)

clean: ## Remove everything that is built; the database under var/ stays
	@rm -rf $(VENV) web/node_modules web/dist app/static estimators/_compiled dist build
