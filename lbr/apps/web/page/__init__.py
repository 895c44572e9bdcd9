"""The robot's page, as a face: the files in `dist/`, built from the sources beside this module."""
