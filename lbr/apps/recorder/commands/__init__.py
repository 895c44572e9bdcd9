"""`lbr box`, `record`, `replay`, `at`, `plot` and `logs`."""
