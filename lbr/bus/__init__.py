"""The one wire between processes. Nothing outside this package imports zenoh."""
