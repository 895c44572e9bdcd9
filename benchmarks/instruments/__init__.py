"""What only benchmarks need to load, to hold up and to compare."""
