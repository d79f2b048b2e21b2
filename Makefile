# make demo                   set up everything, run the sample through the live graph, ask it
# make demo SOURCE=<folder>   the same with frame-NNNNNN.color.jpg, .depth.png, .pose.txt of yours
# make furniture              optional: models for realistic rooms (Debian package, 120 MB)
# make test                   set up everything, check and test everything
# make site                   the documents as a site in out/site
# make sbom                   what is installed, as a CycloneDX bill of materials in out/sbom.json
SHELL := bash
VENV ?= .venv
PYTHON ?= python3
RUN := $(abspath $(VENV))/bin
SOURCE ?= tools/sample
OUT ?= out/demo

# The tests start hundreds of processes, and each would compile everything anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: setup furniture demo test lint site unit browser integration wheel wheel-clean sbom clean

setup: $(VENV)/.ready

$(VENV)/.ready: pyproject.toml $(wildcard deploy/*.lock)
	@deploy/system-libraries
	@echo "setting up $(VENV)"
	@$(PYTHON) -m venv $(VENV)
	@PYTHON=$(RUN)/python deploy/install-python
	@$(RUN)/python -m sceneq_nodes._assets
	@touch $@

furniture:
	@deploy/apt-install sweethome3d-furniture

demo: setup
	@$(RUN)/sceneq demo "$(SOURCE)" "$(OUT)"

test: lint site unit integration wheel

lint: setup
	$(RUN)/ruff check .
	$(RUN)/ruff format --check .
	PYTHON=$(RUN)/python .ci/typecheck

# The documents as a site; a broken link fails.
site: setup
	@NO_MKDOCS_2_WARNING=1 $(RUN)/mkdocs build --strict -f deploy/site/mkdocs.yml

unit: setup
	$(RUN)/python -m pytest -q -n auto --dist worksteal -m "not integration"

# They wait more than they compute; which of them go together: tests/integration/conftest.py.
SIDE_BY_SIDE := -n 2 --dist loadfile --no-loadscope-reorder

# The console's tests need a browser; without one they are skipped and say so.
browser:
	@command -v chromium >/dev/null || deploy/apt-install chromium || true

integration: setup browser
	$(RUN)/python -m pytest -q -m integration $(SIDE_BY_SIDE) tests/integration

wheel: setup
	PYTHON=$(RUN)/python .ci/wheel

# The same in an empty environment, with everything from the package index.
wheel-clean: setup
	PYTHON=$(RUN)/python .ci/wheel --download

sbom: setup
	@mkdir -p out
	@PYTHON=$(RUN)/python .ci/sbom out/sbom.json

clean:
	rm -rf $(VENV) out build dist .typecheck
