"""Cameras, numbers and the path of a robot in a notebook: the exports of `lbr.client.notebook`."""

from lbr.client.notebook import plot, show, way

__all__ = ["plot", "show", "way"]
