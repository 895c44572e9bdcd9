"""navcam: the robot's cameras in a browser, behind a token. `python -m lbr.apps.navcam --help`."""
