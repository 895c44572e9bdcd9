"""The SQL that makes a new database: the schema with the robot lbr, and the rows that packages of lbr's bring."""

from lbr.resources import robot_db_sql
from lbr.robot import registry


def sql() -> str:
    brought = (found.robot.rows for found in registry.every() if found.robot is not None and found.package == "lbr")
    return "\n".join(path.read_text(encoding="utf-8") for path in (robot_db_sql(), *filter(None, brought)))
