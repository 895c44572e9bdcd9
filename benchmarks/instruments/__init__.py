"""Tools that only benchmarks need: for load, delays and comparisons."""
