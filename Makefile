# make run    set up, drive the rig, fit, report into out/    (RIG=name or rigs/file.toml)
# make test   set up and run every test
# make help   the rest

RIG ?= sim
OUT ?= out
# three more than there are cores: many tests wait for a board, a server or a browser
JOBS ?= $(shell expr $$(nproc 2>/dev/null || echo 2) + 3)
SECONDS ?= 60
# test files whose assertions one process rewrites
SHARE := 350
PYTHON ?=
export PYTHON
# Empty is unset: where no byte code may be kept, each worker and each command that a test starts
# compiles everything anew, which takes a third of the quick suite's time.
export PYTHONDONTWRITEBYTECODE =

VENV := .venv
PY := $(VENV)/bin/python
PYTEST := $(PY) -m pytest -q -n $(JOBS) --dist worksteal
# what cffi writes itself begins with an underscore
C_SOURCES := $(filter-out $(wildcard motorid/*/_*), \
    $(wildcard motorid/*/*_build.py motorid/*/*.c motorid/*/*.h))
READY := $(VENV)/ready
READY_TO_TEST := $(VENV)/ready-to-test
REWRITTEN := $(VENV)/tests-rewritten

.PHONY: run test quick evidence check frozen mutants fuzz bench docs site format lock sbom wheel wheels help clean

run: $(READY)
	$(VENV)/bin/motorid run --rig $(RIG) -o $(OUT) --force

test: $(READY_TO_TEST) $(REWRITTEN)
	$(PYTEST) --strict-skips

quick: JOBS := $(shell nproc 2>/dev/null || echo 2)
quick: $(READY_TO_TEST)
	$(PYTEST) -m "not slow" --durations=5 --durations-min=0.5

evidence: $(READY_TO_TEST)
	$(PY) bench/evidence.py $(if $(SHORT),--short) $(if $(PARTS),--parts $(PARTS))

check: $(READY_TO_TEST)
	$(PY) -m ruff format --check .
	$(PY) -m ruff check .
	$(PY) -m mypy
	$(VENV)/bin/lint-imports
	$(PY) -m vulture
	$(PY) -m motorid.wire.generate --check
	$(PY) tools/commands_page.py --check
	$(PY) tools/influence_page.py --check
	$(PY) tools/glossary_page.py --check
	$(PY) -m tools.supply.lock --check
	$(PY) -m tools.supply.licences --check
	$(PY) tools/sentences.py

frozen: $(READY_TO_TEST)
	$(PY) -m tests.frozen $(if $(AGAINST),--against $(AGAINST))

mutants: $(READY_TO_TEST)
	$(PY) -m tools.mutants $(if $(COUNT),--count $(COUNT)) $(if $(ROOMS),--rooms $(ROOMS)) \
	    $(if $(TESTS),--tests $(TESTS)) $(if $(THEN),--then $(THEN)) $(if $(SEED),--seed $(SEED))

fuzz: $(READY_TO_TEST)
	@set -e; for target in wire rig csv look journal board fit hdf5 mat; do echo "== $$target"; \
	    $(PY) -m tests.fuzz.run $$target --seconds $(SECONDS); done
	$(PY) -m tests.fuzz.bit_flips --flips 10000
	$(MAKE) -C firmware fuzz PYTHON=$(abspath $(PY)) FUZZ_SECONDS=$(SECONDS)

bench: $(READY_TO_TEST)
	@set -e; for script in bench/bench_*.py; do echo "== $$script"; $(PY) $$script; done

docs: $(READY_TO_TEST)
	$(PY) -m motorid.wire.generate
	$(PY) tools/commands_page.py
	$(PY) tools/influence_page.py
	$(PY) tools/glossary_page.py

site: $(READY_TO_TEST)
	$(PY) -m mkdocs build --strict --quiet

format: $(READY_TO_TEST)
	$(PY) -m ruff format .
	$(PY) -m ruff check --fix .

lock: $(READY_TO_TEST)
	$(PY) -m tools.supply.lock $(if $(UPGRADE),--upgrade)

sbom: $(READY_TO_TEST)
	$(PY) -m tools.supply.bill dist

wheel: $(READY_TO_TEST)
	$(MAKE) -C firmware hex
	MOTORID_RELEASE=1 $(PY) -m pip wheel -q --no-deps --no-build-isolation -w dist .
	$(PY) -m tools.supply.bill dist

wheels: $(READY_TO_TEST)
	$(PY) -m tools.building.wheels $(TARGETS)
	$(PY) -m tools.supply.bill dist

$(READY): pyproject.toml setup.py locks/run.txt locks/test.txt tools/setup.sh \
    tools/building/zig_build.py $(C_SOURCES)
	FOR=$(FOR) sh tools/setup.sh run
	@touch $@

$(READY_TO_TEST): FOR = test
$(READY_TO_TEST): $(READY)
	sh tools/setup.sh test
	@touch $@

# pytest rewrites each test file's assertions once and keeps them. In a fresh checkout every worker
# would rewrite all of them at the same time: first a process a core takes a share. What changes later
# is little. A file that cannot be read is reported by the tests themselves.
$(REWRITTEN): $(READY_TO_TEST)
	-@find tests -name 'test_*.py' | xargs -n $(SHARE) -P $(shell nproc 2>/dev/null || echo 2) \
	    $(PY) -m pytest --collect-only -qq >/dev/null
	@touch $@

clean:
	rm -rf $(VENV) build out .mypy_cache .ruff_cache .pytest_cache
	find motorid -name '*.so' -delete

help:
	@echo "make run [RIG=sim] [OUT=out]  capture, fit and report; RIG is a packaged name or a file"
	@echo "make test                     every test"
	@echo "make quick                    the tests that take less than about a tenth of a second each"
	@echo "make evidence [PARTS=...]     what takes hours, into bench/results; SHORT=1 for a moment"
	@echo "make check                    format, lint, types, generated files, lock, licences"
	@echo "make frozen [AGAINST=commit]  every number of a fixed corpus, as recorded or as that commit's bits"
	@echo "make mutants [ROOMS=...] [COUNT=60] [SEED=1] [TESTS=\"'not slow'\"] [THEN=slow]  faults put in on purpose: do tests see them?"
	@echo "make fuzz [SECONDS=60]        each parser and the firmware's receiver, for so long"
	@echo "make bench                    speed and accuracy against their targets"
	@echo "make docs                     write the generated documents"
	@echo "make site                     the site of docs/, into build/site"
	@echo "make format                   format and mend lint"
	@echo "make lock [UPGRADE=1]         write the lock of what is installed, with hashes"
	@echo "make sbom                     the bill of materials and the third-party notices, into dist/"
	@echo "make wheel                    a release's wheel, with the boards' firmware, into dist/"
	@echo "make wheels [TARGETS=...]     the same for Linux, Windows and macOS, by ziglang (411 MB)"
	@echo "make clean                    remove the environment and everything built"
