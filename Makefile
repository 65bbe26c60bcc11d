# make demo   fly the paper's circle and write a report       make test   run every test
# make lint   ruff and mypy                                    make bench  the measurements the README and docs/ name

PYTHON ?= python3
BIN := .venv/bin

demo: .venv/installed-report
	$(BIN)/companion demo

test: .venv/installed-test
	$(BIN)/python -m pytest

lint: .venv/installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: .venv/installed-test
	for script in $(filter-out bench/__init__.py bench/gallery.py,$(wildcard bench/*.py)); do echo "== $$script"; $(BIN)/python -m bench.$$(basename $$script .py) || exit 1; done

.venv/installed-%: pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[$*]'
	touch $@

gallery: .venv/installed-report
	$(BIN)/python bench/gallery.py

schema: .venv/installed-test
	for kind in mission vehicle world; do $(BIN)/companion schema $$kind > schema/$$kind.schema.json || exit 1; done

clean:
	rm -rf .venv flights

.PHONY: demo test lint bench gallery schema clean
