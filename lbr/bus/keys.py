"""The key space: `<robot>/<capability>/<name>` for streams and commands, `<robot>/@…` for the system."""

ANY_STATUS = "*/@status"
"""The key that asks every robot behind a router for its name."""


def port(robot: str, capability: str, name: str) -> str:
    """Return the key of a capability's stream or command."""
    return f"{robot}/{capability}/{name}"


def console(robot: str, role: str = "operate") -> str:
    """Return the key for console lines of a role; a sender with access to it has that role's rights."""
    return f"{robot}/@console" if role == "operate" else f"{robot}/@console/{role}"


def console_of_pages(robot: str, role: str = "operate") -> str:
    """Return the key for console lines of a role from servers of pages; it gives a person no access."""
    return f"{robot}/@console/page/{role}"


def estop(robot: str) -> str:
    """Return the key that latches the emergency stop."""
    return f"{robot}/@estop"


def estop_reset(robot: str) -> str:
    """Return the key whose query asks the executive to release the emergency stop."""
    return f"{robot}/@estop/reset"


def estop_release(robot: str, capability: str) -> str:
    """Return the key on which the executive releases one mover's latch."""
    return f"{robot}/@estop/release/{capability}"


def estop_acknowledgement(robot: str, capability: str) -> str:
    """Return the key on which a mover reports that its device has stopped."""
    return f"{robot}/@estop/ack/{capability}"


def edit(robot: str, capability: str = "") -> str:
    """Return the key on which the executive receives edits of rows, from capabilities wired to `executive.edit`.

    Of a capability: the key on which it receives edits of its own rows, from the executive alone.
    """
    return f"{robot}/@edit/{capability}" if capability else f"{robot}/@edit"


def pair(robot: str) -> str:
    """Return the key on which the executive receives the digits of a code, for a token, from kinds that pair."""
    return f"{robot}/@pair"


def manage(robot: str) -> str:
    """Return the key on which the executive receives people's requests about rows, tokens and logs."""
    return f"{robot}/@manage"


def status(robot: str) -> str:
    """Return the key of the robot's status, a stream and a query."""
    return f"{robot}/@status"


def event(robot: str) -> str:
    """Return the key of the event stream."""
    return f"{robot}/@event"


def taped(robot: str, capability: str) -> str:
    """Return the key on which a capability reports its lines' bytes and its commands to a recorder."""
    return f"{robot}/@taped/{capability}"


def alive(robot: str, capability: str) -> str:
    """Return the key of a capability's liveliness token."""
    return f"{robot}/@alive/{capability}"


def host(robot: str, name: str) -> str:
    """Return the key on which a host of the robot reports; the answer is its share of the processes."""
    return f"{robot}/@host/{name}"


def agent_alive(robot: str, host: str) -> str:
    """Return the key of the liveliness token of a host's agent; no capability can have such a name."""
    return alive(robot, agent(host))


def agent(host: str) -> str:
    """Return the name of a host's agent among the processes."""
    return f"{host}.agent"


def schema(robot: str, capability: str, name: str) -> str:
    """Return the key that answers with the JSON Schema of a stream or command."""
    return f"{robot}/@schema/{capability}/{name}"


def router(robot: str, session_id: str) -> str:
    """Return the key on which one of the executive's routers answers, so that its links can be tested."""
    return f"{robot}/@router/{session_id}"


def looked_at(robot: str) -> tuple[str, ...]:
    """Return the keys on which the robot reports its own state."""
    return status(robot), ANY_STATUS, event(robot), schema(robot, "*", "*")
