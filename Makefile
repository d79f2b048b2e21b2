# make demo SOURCE=<folder>   set up everything, run the folder through the live graph, ask it
# make test                   set up everything, check and test everything
SHELL := bash
VENV ?= .venv
PYTHON ?= python3
RUN := $(abspath $(VENV))/bin
OUT ?= out/demo

.PHONY: setup demo test lint unit integration wheel clean

setup: $(VENV)/.ready

$(VENV)/.ready: pyproject.toml $(wildcard deploy/*.lock)
	@deploy/system-libraries
	@echo "setting up $(VENV)"
	@$(PYTHON) -m venv $(VENV)
	@PYTHON=$(RUN)/python deploy/install-python
	@$(RUN)/python -m sceneq_nodes._assets
	@touch $@

demo: setup
	@test -n "$(SOURCE)" || { echo "usage: make demo SOURCE=<folder with frame-NNNNNN.color.jpg, .depth.png, .pose.txt>"; exit 2; }
	@$(RUN)/sceneq demo "$(SOURCE)" "$(OUT)"

test: lint unit integration wheel

lint: setup
	$(RUN)/ruff check .
	$(RUN)/ruff format --check .
	PYTHON=$(RUN)/python .ci/typecheck

unit: setup
	$(RUN)/python -m pytest -q -m "not integration"

integration: setup
	$(RUN)/python -m pytest -q -m integration

wheel: setup
	PYTHON=$(RUN)/python .ci/wheel

clean:
	rm -rf $(VENV) out build dist .typecheck
