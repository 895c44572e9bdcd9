"""A robot's body as data, to be drawn: links, joints, shapes and sensors, from the descriptions that the simulated
worlds have.

    body.xml (MJCF) ──► mjcf.read ──► Body ──► RobotModel, with the limits of the joint rows
    rows of wheels and range sensors ──► wheeled.body ──► Body ─┘

Nothing here needs a physics engine. Metres and radians; x ahead, y left, z up (REP 103).
"""
