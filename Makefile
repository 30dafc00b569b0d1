# make demo   set everything up and reproduce the founding paper, leaving demo/paper/index.html
# make test   set everything up and run every check (scripts/check)
# make bench  the benchmark against its peers (installs heyoka for that)

.PHONY: demo test bench clean
.DELETE_ON_ERROR:

READY := .venv/ready

demo: $(READY)
	.venv/bin/ridedown paper --out demo/paper
	.venv/bin/ridedown run example-offset --out demo/run
	@echo
	@echo "The paper reproduced: demo/paper/index.html. One crash in full: demo/run/index.html."

test: $(READY)
	scripts/check .venv/bin

bench: $(READY)
	.venv/bin/pip install --quiet --editable '.[benchmark]'
	.venv/bin/python benchmarks/p1.py

clean:
	rm -rf .venv demo dist .mypy_cache .pytest_cache .ruff_cache .import_linter_cache .hypothesis

$(READY): pyproject.toml scripts/setup
	scripts/setup .venv
	touch $@
