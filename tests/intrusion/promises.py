"""What an attack may never get."""

from tests.support.figures import Promise

PROMISES: dict[str, Promise] = {
    "F6": Promise(what="outputs within the configured maximum and slew, in every scenario"),
    "A1": Promise(what="default profile: no open port, no multicast, no packet sent, in a network of its own"),
    "A3": Promise(what="stolen credentials of a process: nothing read, written, answered or feigned beyond its wiring"),
    "A10": Promise(what="`!` lines through every entry: only the robot's own terminal runs them, and it is audited"),
    "A11": Promise(what="rows and files that would load foreign code: refused, nothing imported"),
    "A12": Promise(what="shell metacharacters in rows and lines of external commands: no effect"),
    "A14": Promise(what="dependencies are locked by hash, and the lock fits the project"),
    "A15": Promise(what="each process: no capabilities, no new privileges, own files and devices only"),
}
