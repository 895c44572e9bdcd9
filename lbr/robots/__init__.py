"""Robots that packages bring: rows, launch profiles and bodies, declared by one object and found by its entry point."""

from lbr.robots.robot import Robot

__all__ = ["Robot"]
