"""A robot's body as data for drawing: links, joints, shapes and sensors, from the descriptions of simulated worlds.

    body.xml (MJCF) ──► mjcf.read ──► Body ──► RobotModel, with the limits of the joint rows
    rows of wheels and range sensors ──► wheeled.body ──► Body ─┘

Nothing here needs a physics engine. Metres and radians; x ahead, y left, z up (REP 103).
"""
