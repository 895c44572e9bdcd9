"""Rows to processes: plan, supervisor, and the operator's way in."""
