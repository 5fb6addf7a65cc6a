"""The papers' tables and figures, on data at hand: one module a paper."""
