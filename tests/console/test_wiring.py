from lbr.console import wiring
from lbr.database.rows import CapabilityRow, ChannelRow, RobotRow, RobotRows, VerbRow

ROWS = RobotRows(
    robot=RobotRow(name="rob"),
    capabilities=(CapabilityRow(name="drive", kind="drive"), CapabilityRow(name="cam", kind="camera", enabled=False)),
    channels=(
        ChannelRow(source="drive.setpoint", target="motors.setpoint"),
        ChannelRow(source="cam.frame", target="web.frame", enabled=False),
    ),
    verbs=(
        VerbRow(word="s", pattern="s", target="drive.stop", role="view", help=""),
        VerbRow(word="help", pattern="help", target="executive.help", role="view", help=""),
    ),
)


def test_the_tree_shows_under_each_capability_what_it_sends_and_to_whom():
    graph = wiring.graph(ROWS, {"drive": "ready"}, {"drive.setpoint": 50.0})
    assert wiring.tree(graph) == [
        "rob",
        "|- drive (drive, ready)",
        "|  `- setpoint -> motors.setpoint  50 Hz",
        "|- cam (camera, disabled)",
        "|  `- frame -> web.frame  (off)",
        "`- console",
        "   `- s -> drive.stop",
    ]


def test_the_graph_and_dot_name_every_wire():
    graph = wiring.graph(ROWS, {}, {})
    assert '  "drive" -> "motors" [label="setpoint > setpoint"];' in wiring.dot(graph)
    assert '  "cam" -> "web" [label="frame > frame", style=dashed];' in wiring.dot(graph)
    assert [edge.target for edge in graph.edges] == ["motors.setpoint", "web.frame", "drive.stop"]
