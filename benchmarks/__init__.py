"""Measurements of a whole simulated robot: stopping, supervision, latency, footprint."""
