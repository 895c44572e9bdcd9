"""A device row that is added to a running simulated robot: the world goes on, and emulates it, or says that it does not."""

from tests.support.waiting import until


def world(robot):
    return robot.capability("world")["pid"], robot.capability("ranges")["pid"]


def told(robot, kind):
    return [event["text"] for event in robot.events() if event["kind"] == kind]


def test_the_world_takes_in_what_is_plugged_in_and_begins_again_only_for_what_moves_it(robot):
    before, restarts = world(robot), len(told(robot, "restarting"))
    robot.edit("INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'ahrs', 'riox', '/dev/ahrs')")
    robot.edit(
        """INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'ahrs', 'riox', '{"device": "ahrs"}')"""
    )
    until(lambda: robot.ask("ahrs/sample") is not None, what="it measures")
    robot.edit("INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'arm', 'servo_bus', '/dev/arm')")
    until(lambda: any("arm (servo_bus at /dev/arm)" in text for text in told(robot, "no_twin")), what="it is told")
    assert world(robot) == before
    assert len(told(robot, "restarting")) == restarts
    robot.edit("INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'spare', 'roboteq', '/dev/spare')")
    until(lambda: robot.capability("world")["pid"] not in {None, before[0]}, what="it begins again")
    until(lambda: robot.ask("ahrs/sample") is not None, what="all that is plugged in is there again")
    assert "'spare' moves what is in the world" in told(robot, "restarting")[restarts]
