# A virtual environment with the package and all that its tests need.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)

.PHONY: demo test lint benchmark energy study clean

$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable ".[test]"
	touch $@

demo: $(VENV)/.installed
	$(BIN)/pvlib-fem demo

test: $(VENV)/.installed
	$(BIN)/python -m pytest

lint: $(VENV)/.installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

benchmark: $(VENV)/.installed
	$(BIN)/python benchmarks/ratios.py

energy: $(VENV)/.installed
	$(BIN)/python gallery/energy_of_a_year.py

study: $(VENV)/.installed
	$(BIN)/python tests/study.py --shift 50000 --out docs/study.md

clean:
	rm -rf $(VENV) .pytest_cache .ruff_cache .hypothesis
