# `make demo` and `make test` set up what they need in .venv first.
#   make demo PIP_ARGS="--extra-index-url https://download.pytorch.org/whl/cpu"    torch without CUDA (much smaller)
#   make test PYTHON=python3.12                                                     another interpreter

PYTHON   ?= python3
VENV     ?= .venv
PIP_ARGS ?=
ARGS     ?=

# The processes that tests start read compiled sources, as each of them takes a second to compile those it imports.
unexport PYTHONDONTWRITEBYTECODE

BIN         := $(VENV)/bin
INSTALLED   := $(VENV)/.installed
TESTS_READY := $(VENV)/.tests-ready
GUI_READY   := $(VENV)/.gui-ready
DOCS_READY  := $(VENV)/.docs-ready
MUTATE_READY := $(VENV)/.mutate-ready
VERSIONS_READY := $(VENV)/.versions-ready
ROS_READY := build/ros/.ready
LIBRARIES   := build/libraries
LIBRARY_SETS := torchrl benchmarl zoo tianshou pufferlib sample_factory demonstrations agilerl rllib
INSTALL     := $(BIN)/python -m pip install --disable-pip-version-check -c constraints.txt $(PIP_ARGS)

.PHONY: help demo install docs lessons lint ruff mypy test fast-tests test-slow test-bounds test-random test-gui test-ros test-versions \
        test-libraries mutate bench peers clean
.DELETE_ON_ERROR:

help:
	@echo "make demo        train on cluttered_room, evaluate, film; results in runs/demo"
	@echo "make test        ruff, mypy, pytest"
	@echo "make test-slow   the longer checks too"
	@echo "make test-bounds every shipped, documented and compared scenario, and random ones, with bounds checks"
	@echo "make test-random 3,000 random scenarios: no value out of its space, no hang, no traceback (half an hour or more)"
	@echo "make test-gui    real windows, keys and mouse under a virtual screen, and a browser (installs Xvfb, xdotool, Chromium)"
	@echo "make test-ros    a node of ROS 1 drives a simulated robot, on the loopback (installs ROS 1 of Debian)"
	@echo "make test-versions  the contracts with the lowest and the newest of every dependency, in build/versions (gigabytes)"
	@echo "make test-libraries  a dozen other libraries with our environments, in build/libraries (LIBRARY_SETS=zoo: some)"
	@echo "make docs        the site, in build/site (ARGS=--no-pictures: quick, without new pictures)"
	@echo "make lessons     run the notebooks of docs/lessons and keep their outputs (ARGS=NAME: one of them)"
	@echo "make mutate      do the tests notice when the code is wrong? hours, goes on where it was stopped (ARGS=...)"
	@echo "make bench       the benchmarks (ARGS=... is passed on)"
	@echo "make peers       the benchmarks beside ir-sim, navground, VMAS and JaxNav, each in build/peers (ARGS=...)"
	@echo "make clean       remove caches and builds; .venv and runs stay"

demo: $(INSTALLED)
	$(BIN)/irsim-gym demo $(ARGS)

install: $(INSTALLED)

lint: ruff mypy

ruff: $(TESTS_READY)
	$(BIN)/python -m ruff check .
	$(BIN)/python -m ruff format --check .

mypy: $(TESTS_READY)
	$(BIN)/python -m mypy

# mypy has one process, and so leaves cores for the tests.
test: ruff
	@$(MAKE) --no-print-directory -j2 mypy fast-tests

fast-tests: $(TESTS_READY)
	$(BIN)/python -m pytest -n auto --dist worksteal -m "not slow and not gui and not libraries and not ros" $(ARGS)

test-slow: lint $(DOCS_READY)
	$(BIN)/python -m pytest -m "not gui and not libraries and not ros" $(ARGS)

test-bounds: $(TESTS_READY)
	$(BIN)/python -m pytest -n auto tests/bounds/test_bounds.py $(ARGS)

test-random: $(TESTS_READY)
	$(BIN)/python -m pytest -n auto tests/bounds/test_mixed.py $(ARGS)

test-gui: $(GUI_READY)
	tests/gui/system_packages.sh
	$(BIN)/python -m pytest -m gui tests/gui $(ARGS)

test-ros: $(TESTS_READY) $(ROS_READY)
	$(BIN)/python -m pytest -m ros tests/ros $(ARGS)

test-versions: $(VERSIONS_READY)
	PIP_ARGS="$(PIP_ARGS)" $(BIN)/python tests/versions/run.py $(ARGS)

test-libraries: $(LIBRARY_SETS:%=$(LIBRARIES)/%/.ready)
	set -e; for set in $(LIBRARY_SETS); do $(LIBRARIES)/$$set/bin/python -m pytest -m libraries tests/libraries $(ARGS); done

docs: $(DOCS_READY)
	$(BIN)/python docs/build.py $(ARGS)

lessons: $(DOCS_READY)
	$(BIN)/python docs/run_lessons.py $(ARGS)

mutate: $(MUTATE_READY)
	$(BIN)/python tests/mutation/run.py $(ARGS)

bench: $(TESTS_READY)
	$(BIN)/python benchmarks/run.py $(ARGS)

peers: $(TESTS_READY)
	PIP_ARGS="$(PIP_ARGS)" $(BIN)/python benchmarks/peers.py $(ARGS)

clean:
	rm -rf build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -path ./$(VENV) -prune -o -name __pycache__ -type d -prune -exec rm -rf {} +

define MAKE_VENV
@$(PYTHON) -c 'import sys; sys.exit("irsim_gym needs Python 3.11 or newer: make PYTHON=python3.12" if sys.version_info < (3, 11) else 0)'
@$(BIN)/python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv --clear $(VENV)
endef

# An interrupted set-up leaves no stamp, and the next run takes it up again.
$(INSTALLED): pyproject.toml constraints.txt
	$(MAKE_VENV)
	$(INSTALL) -e ".[train]"
	@echo "Compiling the kernels of docs/start.md, so that they need not be waited for later."
	@$(BIN)/irsim-gym warmup cluttered_room circle_swap || true
	@touch $@

$(TESTS_READY): pyproject.toml constraints.txt
	$(MAKE_VENV)
	$(INSTALL) -e ".[test]"
	@touch $(INSTALLED) $@

$(GUI_READY): $(TESTS_READY)
	$(INSTALL) -e ".[test,test-gui,docs]"
	@touch $@

$(DOCS_READY): $(INSTALLED)
	$(INSTALL) -e ".[docs]"
	@touch $@

# ROS 1 runs under the Python of the system.
$(ROS_READY): tests/ros/system_packages.sh constraints.txt $(TESTS_READY)
	tests/ros/system_packages.sh
	/usr/bin/python3 -m venv --clear --without-pip --system-site-packages $(@D)
	$(BIN)/python -m pip --python $(@D) install --disable-pip-version-check -c constraints.txt $(PIP_ARGS) numpy onnxruntime
	@touch $@

$(VERSIONS_READY): $(TESTS_READY)
	$(INSTALL) -e ".[test,versions]"
	@touch $@

# They want conflicting versions of tensordict and others, so each set has its own environment. AgileRL's trainers import
# peft, which its package does not ask for. imitation and Sample Factory refuse Gymnasium 1 and NumPy 2 in their metadata
# and work with both: they are installed without their dependencies, and those that they import by name.
REQUIRED_torchrl := torchrl==0.14.1 skrl==2.1.1 supersuit==3.11.0
REQUIRED_benchmarl := benchmarl==1.5.2 torchrl==0.11.1
REQUIRED_zoo := rl_zoo3==2.9.2 sbx-rl==0.28.0
REQUIRED_tianshou := tianshou==2.0.1
REQUIRED_pufferlib := pufferlib-core==3.0.19
REQUIRED_sample_factory := "signal-slot-mp<2" colorlog faster-fifo "huggingface-hub<1" opencv-python-headless psutil \
	pyglet tensorboardx threadpoolctl wandb
REQUIRED_demonstrations := "minari[create,hdf5]==0.5.4" datasets huggingface_sb3 sacred scikit-learn
REQUIRED_agilerl := agilerl==2.58.0 peft==0.21.0
EXTRA_rllib := rllib
ALONE_sample_factory := sample-factory==2.1.1
ALONE_demonstrations := imitation==1.0.1

$(LIBRARIES)/%/.ready: pyproject.toml constraints.txt Makefile
	$(PYTHON) -m venv --clear $(@D)
	$(@D)/bin/python -m pip install --disable-pip-version-check -c constraints.txt $(PIP_ARGS) \
		-e ".[$(or $(EXTRA_$*),train)]" pytest hypothesis $(REQUIRED_$*)
	$(if $(ALONE_$*),$(@D)/bin/python -m pip install --disable-pip-version-check --no-deps $(PIP_ARGS) $(ALONE_$*))
	@touch $@

$(MUTATE_READY): $(TESTS_READY)
	$(INSTALL) -e ".[test,mutate]"
	@touch $@
