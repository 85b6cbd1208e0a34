# Everything starts from a fresh clone: the first target creates .venv and installs the project into it.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
BENCH_STAMP := $(VENV)/.installed-bench

.PHONY: help install demo serve test check bench clean
.DEFAULT_GOAL := help

help: ## Show this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 12

$(STAMP): pyproject.toml constraints.txt
	@echo "Installing Jointscope into $(VENV) (first use, about a minute) ..."
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,export,cluster,postgres]'
	@touch $@

$(BENCH_STAMP): $(STAMP)
	$(BIN)/pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[bench]'
	@touch $@

# numba looks only at the file of the function that is called; a changed file that it calls into would go unnoticed.
KERNELS := $(shell find daq estimators mock_dsp server discrepancy -name 'kernels.py' -o -path '*/kernels/*.py' 2>/dev/null)
$(VENV)/.kernels: $(KERNELS) $(STAMP)
	@find . -path ./$(VENV) -prune -o \( -name '*.nbi' -o -name '*.nbc' \) -print | xargs -r rm -f
	@touch $@

install: $(STAMP) ## Create .venv and install everything

demo: $(STAMP) $(VENV)/.kernels ## The paper's campaign on the emulated rig, then a hidden effect
	$(BIN)/jointscope demo --out out/demo

serve: $(STAMP) $(VENV)/.kernels ## The service with the emulated rig; prints its address and, once, a token
	$(BIN)/jointscope serve --data out/service --emulate config/scenarios/nominal.yaml

check: $(STAMP) $(VENV)/.kernels ## Lint, types, import rules and the quick tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/pytest -q -m 'not slow'

test: $(STAMP) $(VENV)/.kernels ## Lint, types, import rules and every test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/pytest -q

bench: $(BENCH_STAMP) $(VENV)/.kernels ## Measure what benchmarks/README.md claims
	$(BIN)/python -m benchmarks

clean: ## Remove what the targets above created
	rm -rf $(VENV) out build *.egg-info
