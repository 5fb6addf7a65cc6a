"""Benchmarks: ``python -m benchmarks`` prints every table; nothing here is a test."""
