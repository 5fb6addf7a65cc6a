"""How good a result is: metrics, baselines and held-out protocols."""
