"""Cameras, numbers and the way of a robot in a notebook: what `lbr.client.notebook` has."""

from lbr.client.notebook import plot, show, way

__all__ = ["plot", "show", "way"]
