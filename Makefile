# The two commands of the README, and the step that they share. Windows: see README.md, no make needed.

PYTHON_VENV := .venv/bin/python
PICTURES ?= pictures
PYTEST_ARGS ?=

.PHONY: help setup demo test lint clean distclean

help:
	@echo "make setup      install what is missing and make .venv (quick when nothing changed)"
	@echo "make demo       setup, then render the demo pictures without a display (PICTURES=folder, default pictures)"
	@echo "make test       setup, then the whole test suite (PYTEST_ARGS='-k name')"
	@echo "make lint       setup, then ruff"
	@echo "make clean      remove pictures, caches and build output"
	@echo "make distclean  clean, and remove .venv"

setup:
	@sh tools/setup.sh

demo: setup
	@$(PYTHON_VENV) demo.py --headless --out "$(PICTURES)"
	@echo "The pictures are in $$(cd "$(PICTURES)" && pwd)"

test: setup
	@$(PYTHON_VENV) -m pytest -n 2 --dist loadfile $(PYTEST_ARGS)

lint: setup
	@$(PYTHON_VENV) -m ruff check .

clean:
	rm -rf build dist pictures *.egg-info .pytest_cache .ruff_cache .hypothesis
	find . -path ./.venv -prune -o -path ./.git -prune -o -type d -name __pycache__ -print | xargs rm -rf

distclean: clean
	rm -rf .venv
