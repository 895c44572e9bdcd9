"""The bus between processes. Nothing outside this package imports zenoh."""
