# Programs that are not ours open what we write; see tests/clients/check.py.
.PHONY: check-clients
PYTHON ?= python3
check-clients:
	npm --prefix tests/clients ci --no-audit --no-fund
	test -x .venv/bpy/bin/python || (python3 -m venv .venv/bpy && .venv/bpy/bin/pip install bpy==5.0.1)
	$(PYTHON) tests/clients/check.py --blender .venv/bpy/bin/python
