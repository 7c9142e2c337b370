# `make demo` and `make test` set up what they need in .venv; they need python3 (3.11+) with venv, its
# header files, and a C++ compiler.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO_READY := $(VENV)/demo-ready
READY := $(VENV)/ready
COMPILED := $(VENV)/compiled
ALL := --no-build-isolation --editable '.[all,dev,docs]' --editable ./studio --editable './fleet[mqtt]' \
	--editable './lab[peers]'
# uv takes a quarter of pip's time. It does not read pip's settings: what it cannot find, pip installs,
# of which an environment takes seconds to get a copy. Modules are compiled when they are imported:
# most never are.
UV := $(or $(shell command -v uv 2>/dev/null),$(BIN)/uv)
PIP := $(BIN)/python -m ensurepip > /dev/null && $(BIN)/python -m pip install --quiet --no-compile
install = $(UV) pip install --quiet --python $(BIN)/python $(1) || { $(PIP) $(1); }
SOURCES := $(wildcard src/motes/kernels/*.hpp src/motes/kernels/*.cpp)
KERNELS := $(VENV)/kernels
# Real films: SEQUENCES in OTB's layout, and others. See lab/docs/results.md for their names in commands.
DATA := $(or $(MOTES_DATA),../shared/data)/sot

# What `make bench` scales and follows, and files of a trained network: NANO=BACKBONE,HEAD.
FILM := $(dir $(DATA))video/sam2_cups.mp4
BOX := 570,292,168,252
NANO :=

# How long `make fuzz` runs, how often `make kills` kills, and with which random numbers.
SECONDS := 60
KILLS := 200
SEED := 0

# Which tables `make results` makes; all by default.
ONLY :=

# Tests start many programs, each of which would compile its modules anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: ready demo check test suite coverage lint docs golden gallery bench results fuzz kills sanitize clean

demo: $(DEMO_READY)
	@$(MAKE) --no-print-directory $(KERNELS)
	$(BIN)/motes demo --out demo --overwrite

# While working: all but what is slow, and what needs a browser or Ray.
check: lint
	$(BIN)/python -m pytest -n auto

# Types are checked beside the tests.
test: ready
	@$(MAKE) --no-print-directory -j 2 lint suite

suite: ready $(COMPILED)
	$(BIN)/python -m pytest -m '' -n auto

# The first time, modules are compiled before all workers need them; later, few have changed.
$(COMPILED): | ready
	@-$(BIN)/python -m pytest --collect-only -qq > /dev/null
	touch $@

# It takes longer than the tests alone, and ends with an error below the floor in pyproject.toml.
coverage: ready
	$(BIN)/coverage erase
	$(BIN)/coverage run -m pytest -m '' -n auto
	$(BIN)/coverage combine --quiet
	$(BIN)/coverage report

lint: ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/clang-format --dry-run --Werror $(SOURCES)

# The site, in site/, and that of the lab: strict, so that a broken link or heading ends it, and without network.
docs: ready
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --config-file lab/mkdocs.yml
	@echo "Open site/index.html"

# The pictures of the gallery, of the README, of other pages and of the studio: some need Chromium.
gallery: ready
	$(BIN)/python docs/generate/gallery.py
	$(BIN)/python docs/generate/gallery_pages.py
	$(BIN)/python docs/generate/studio_pictures.py

# Outputs of whole commands, to the byte: before code moves, and after. They are kept by --keep.
golden: ready
	$(BIN)/python tests/golden/golden.py

# Into bench/; what needs real film is left out where there is none.
bench: ready
	$(BIN)/python -m pytest -m '' benchmarks --benchmark-enable --benchmark-only
	$(BIN)/motes-lab bench --against lab/docs/performance.md --out bench --overwrite \
		$(if $(wildcard $(DATA)),--data $(DATA) $(if $(NANO),--nano $(NANO)))
	$(if $(wildcard $(FILM)),$(BIN)/python benchmarks/end_to_end.py $(FILM) $(BOX))

# All measured tables of docs/ and lab/docs/, the shortest first: one night on two cores. What has been
# measured is in results/: a run that was stopped goes on. `docs/generate/results.py --list` has times.
results: ready
	$(BIN)/python docs/generate/results.py $(ONLY)

fuzz: ready
	PYTHONPATH=tests $(BIN)/python -m fuzzing --seconds $(SECONDS) --seed $(SEED)

kills: ready
	PYTHONPATH=tests $(BIN)/python -m fuzzing.kills --kills $(KILLS) --seed $(SEED)

# Kernels that end the process at an access beside an array, a number that is no index, and all else that
# C++ does not define: their tests, and calls of public functions with what nobody means.
SANITIZERS := -O1 -g1 -fno-omit-frame-pointer -fno-sanitize-recover=all \
	-fsanitize=address,undefined,float-cast-overflow
CALLS := 200
sanitize: ready
	rm -rf sanitize
	MOTES_KERNEL_FLAGS="$(SANITIZERS)" LDFLAGS="-fsanitize=address,undefined" \
		$(BIN)/python setup.py --quiet build --build-base sanitize/build --build-lib sanitize/lib
	LD_PRELOAD="$$(c++ -print-file-name=libasan.so) $$(c++ -print-file-name=libstdc++.so)" \
		ASAN_OPTIONS=detect_leaks=0 PYTHONPATH=sanitize/lib:tests sh -e -c '\
		$(BIN)/python -m pytest -m "" tests/kernels tests/cues; \
		$(BIN)/python -m fuzzing --kind calls --rounds $(CALLS) --seed $(SEED)'

# What the kernels are built with comes first, so that it is not installed once more to build them.
$(DEMO_READY): pyproject.toml setup.py
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "motes needs Python 3.11 or later; name one with: make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv --without-pip $(VENV)
	@test -x $(UV) || $(PYTHON) -m pip --python $(BIN)/python install --quiet --no-compile uv || \
		{ $(PIP) uv; } || true
	$(call install,pip 'setuptools>=77' 'numpy>=2')
	$(call install,--no-build-isolation --editable .)
	touch $@ $(KERNELS)

# The library, its lab, and what their tests and pages need. TrackEval and Datumaro are what tests
# compare with; of what they ask for, an OpenCV would overwrite ours.
$(READY): $(DEMO_READY) studio/pyproject.toml fleet/pyproject.toml lab/pyproject.toml
	$(call install,$(ALL))
	$(call install,--no-deps trackeval==1.3.0 datumaro==1.13.12)
	touch $@ $(KERNELS)

# The installation has compiled the kernels; they are compiled again when their sources change. A make
# of its own looks at the times of files after the installation.
ready: $(READY)
	@$(MAKE) --no-print-directory $(KERNELS)

$(KERNELS): $(SOURCES)
	$(BIN)/python setup.py --quiet build_ext --inplace
	touch $@

clean:
	rm -rf $(VENV) build */build demo results bench fuzz sanitize site src/motes/kernels/*.so
