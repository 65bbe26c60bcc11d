# make demo   fly the paper's circle and write a report       make test   run every test, on every core
#             make demo DEMO=--plain is undisturbed, DEMO=--fast as fast as the machine computes
# make lint   ruff and mypy                                    make bench  the measurements the README and docs/ name

PYTHON ?= python3
BIN := .venv/bin

demo: .venv/installed-report
	$(BIN)/companion demo $(DEMO)

test: .venv/installed-test
	$(BIN)/python -m pytest -n auto --dist loadgroup

lint: .venv/installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: .venv/installed-test
	for script in $(filter-out bench/__init__.py bench/gallery.py bench/recorded.py,$(wildcard bench/*.py)); do echo "== $$script"; $(BIN)/python -m bench.$$(basename $$script .py) || exit 1; done

.venv/installed-%: pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[$*]'
	touch $@

gallery: .venv/installed-report
	$(BIN)/python bench/gallery.py

schema: .venv/installed-test
	for kind in mission vehicle world study; do $(BIN)/companion schema $$kind > schema/$$kind.schema.json || exit 1; done

# flights/ is never removed: it holds what was flown, and only its owner knows what of it may go
clean:
	rm -rf .venv

.PHONY: demo test lint bench gallery schema clean
