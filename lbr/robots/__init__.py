"""Robots that come with lbr, each whole in its folder: rows, profiles, body, and what only that robot has."""
