.PHONY: check test slow nightly bench coverage site pictures wheel calibrate-models evidence
PYTHON ?= .venv/bin/python

check:
	$(PYTHON) -m ruff check .
	$(PYTHON) -m ruff format --check .
	$(PYTHON) -m mypy
	$(PYTHON) -c "from importlinter.cli import lint_imports_command; lint_imports_command()"

test:
	$(PYTHON) -m pytest

# What `test` leaves out: long runs, other programs, pictures that code has left behind
slow:
	$(PYTHON) -m pytest -m "(slow or programs or pictures) and not nightly" --durations=25

nightly:
	$(PYTHON) -m pytest -m nightly

bench:
	$(PYTHON) benchmarks/starts.py --long
	$(PYTHON) benchmarks/parts.py
	$(PYTHON) benchmarks/predictions.py
	$(PYTHON) benchmarks/space.py --cold
	$(PYTHON) benchmarks/space_crowds.py
	$(PYTHON) benchmarks/page.py
	$(PYTHON) benchmarks/app.py

# How often the bounds of `analyse` hold: an hour and a half, at night; ARGS="--films 10": shorter
coverage:
	$(PYTHON) benchmarks/tracks.py $(ARGS)

site:
	@$(PYTHON) -c "import ipykernel, material, mkdocstrings, nbconvert" 2>/dev/null || { echo "make site: $(PYTHON) -m pip install -e '.[site]'"; exit 2; }
	NO_MKDOCS_2_WARNING=1 $(PYTHON) -m mkdocs build --strict

# Pictures of docs/ whose code has moved on; ONLY=choice,speed: these; ONLY=all: every one
pictures:
	$(PYTHON) docs/pictures.py $(ONLY)

# A wheel of this platform and Python with its kernels compiled: 3 minutes; KERNELS=first: fewer
wheel:
	WALKERGEN_KERNELS=$(or $(KERNELS),all) $(PYTHON) -m build --wheel --no-isolation --outdir $(or $(DIST),dist)

calibrate-models:
	$(PYTHON) -m evidence.tables.train

# What our numbers rest on, beside what is known outside: an hour; ARGS=--quick: minutes, wider error bars
evidence:
	$(PYTHON) -m evidence validate $(ARGS)
	$(PYTHON) -m evidence crowd-checks $(ARGS)
	$(PYTHON) -m evidence crowds-published $(ARGS)
	$(PYTHON) -m evidence walkers-published
	$(PYTHON) -m evidence reproduce
