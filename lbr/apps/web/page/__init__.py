"""The page that the robot serves of itself, as a face: what was built of the sources beside this into `dist/`."""
