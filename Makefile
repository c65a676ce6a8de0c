# A virtual environment with the package and all that its tests need.
PYTHON ?= python3
VENV ?= .venv
# a clone of https://github.com/kperrynrel/time-shift-validation-hub
HUB ?= time-shift-validation-hub
ORACLE = $(VENV)/oracle-study $(VENV)/oracle-instruments
BIN = $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)

.PHONY: demo test test-all fuzz lint dist docs benchmark quality offsets energy study study-measured study-weather study-instruments study-trackers study-events recovery
.PHONY: fleet gate ceiling reliability detectors oracle sweep coverage parameters periods profiles sizes episodes figure clean

$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable ".[test]"
	touch $@

demo: $(VENV)/.installed
	$(BIN)/pvlib-fem demo

# each of the two workers has one core: more threads would wait for each other
test test-all: export OMP_NUM_THREADS = 1
test test-all: export OPENBLAS_NUM_THREADS = 1

# in three minutes on two cores: without tests of years, fleets, studies and pages
test: $(VENV)/.installed
	$(BIN)/python -m pytest -m "not slow" --numprocesses=2 --dist=loadfile

test-all: $(VENV)/.installed
	$(BIN)/python -m pytest --numprocesses=2 --dist=loadfile

# every property with 10,000 examples
fuzz: $(VENV)/.installed
	$(BIN)/python -m pytest tests -m hypothesis --hypothesis-profile=fuzz

lint: $(VENV)/.installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# wheel and sdist, tried in empty environments: newest and oldest dependencies, no git
dist: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet build twine
	-$(BIN)/python -m pip install --quiet py-rattler-build  # of few platforms
	$(BIN)/python tests/dist.py

$(VENV)/.documented: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --editable ".[doc]"
	touch $@

# no network but for the packages: measured data come from PVLIB_FEM_DATA, if it is set
docs: $(VENV)/.documented
	$(BIN)/python -m sphinx -W --keep-going -T -b html -d docs/_build/doctrees docs docs/_build/html
	$(BIN)/python docs/check.py docs/_build/html

benchmark: $(VENV)/.installed
	$(BIN)/python benchmarks/ratios.py
	$(BIN)/python benchmarks/fleet.py

# 200 simulated systems with known causes, on two workers of which one is killed
fleet: $(VENV)/.installed
	$(BIN)/python benchmarks/fleet.py

# pvanalytics works with pandas before 3 only, so that it has an environment of its own
quality:
	$(PYTHON) -m venv $(VENV)-quality
	$(VENV)-quality/bin/python -m pip install --quiet --editable ".[compare]"
	$(VENV)-quality/bin/python benchmarks/quality.py

# what the paper's recipe leaves by the offset that it takes off, for docs/paper.md
offsets: $(VENV)/.installed
	$(BIN)/python benchmarks/offsets.py

energy: $(VENV)/.installed
	$(BIN)/python gallery/05_energy_of_a_year.py

study: $(VENV)/.installed
	$(BIN)/python studies/study.py --gate --table $(VENV)/study --out docs/study.md

# what it says of instruments that change among physics
study-instruments: $(VENV)/.installed
	$(BIN)/python studies/study_instruments.py --gate --table $(VENV)/instruments \
		--out docs/study_instruments.md

# what it says of records of trackers
study-trackers: $(VENV)/.installed
	$(BIN)/python studies/study_trackers.py --out docs/study_trackers.md

# outages and covers that are found in the two measured records of years
study-events: $(VENV)/.installed
	$(BIN)/python studies/study_events.py --out docs/study_events.md

# how often the loop's probabilities are right, from the rows of both, and of the oracle
gate: study study-instruments
	$(BIN)/python studies/study_gate.py $(VENV)/study $(VENV)/instruments \
		$(if $(wildcard $(ORACLE)),--oracle $(ORACLE)) --out docs/gate.md

# what the loop decided by rules, before its statistical model, of the same records
oracle: $(VENV)/.installed
	$(BIN)/python studies/study_oracle.py $(ORACLE)

# what it says of the two measured records of years when their weeks are drawn anew
study-measured: $(VENV)/.installed
	$(BIN)/python studies/study_measured.py --out docs/study_measured.md

# what it says of measured weather with modules by models that it does not fit
study-weather: $(VENV)/.installed
	$(BIN)/python studies/study_weather.py --out docs/study_weather.md

# how much of these records trees on their own columns explain that know no cause
ceiling: $(VENV)/.installed
	$(BIN)/python studies/study_ceiling.py --out docs/ceiling.md

# single checks on the benchmarks of others
detectors: $(VENV)/.installed
	$(BIN)/python -m pip download --quiet --no-deps --dest $(VENV)/wheels pvanalytics==0.2.2
	$(BIN)/python studies/study_detectors.py --hub $(HUB) --out docs/detectors.md \
		--wheel $(VENV)/wheels/pvanalytics-0.2.2-py3-none-any.whl

# what would be found at the two measured plants; it goes on where it was interrupted
recovery: $(VENV)/.installed
	$(BIN)/python studies/study_recovery.py --draws 1 --out docs/study_recovery.md

# how much is found at both, and how often a name is false; it goes on, too
reliability: $(VENV)/.installed
	$(BIN)/python studies/study_reliability.py --trials 20 --out docs/study_reliability.md

# what each criterion of the loop does, halved and doubled
sweep: $(VENV)/.installed
	$(BIN)/python studies/sweep.py --out docs/sensitivity.md

# how often the intervals of a fit hold the truth
coverage: $(VENV)/.installed
	$(BIN)/python studies/study_coverage.py --records 300 --out docs/coverage.md

# how often the ranges of thermal parameters hold the truth of simulated worlds
parameters: $(VENV)/.installed
	$(BIN)/python studies/study_parameters.py --worlds 100 --out docs/study_parameters.md

# the same by the month, where a coefficient changes, for docs/guide/fitting.md
periods: $(VENV)/.installed
	$(BIN)/python studies/study_periods.py --records 200

# sensors that change along no exact step, trend or temporary change
profiles: $(VENV)/.installed
	$(BIN)/python studies/study_profiles.py

# sizes of sensor faults, with and without power or a second sensor
sizes: $(VENV)/.installed
	$(BIN)/python studies/study_sizes.py

# how often noise shows days that stand out, for docs/guide/honesty.md
episodes: $(VENV)/.installed
	$(BIN)/python studies/study_episodes.py

# paper.png, which paper.md shows
figure: $(VENV)/.installed
	$(BIN)/python docs/paper_figure.py paper.png

clean:
	rm -rf $(VENV) $(VENV)-quality dist paper.png .pytest_cache .ruff_cache .mypy_cache .hypothesis docs/_build docs/gallery docs/generated
