"""From the plan to the access rules of the bus: who may publish, ask and answer what. Pure."""

from collections.abc import Iterable
from typing import get_args

from lbr.bus import keys
from lbr.bus.access import Rights
from lbr.executive.planning import sharing
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.messages.system import Role


def of_unit(plan: Plan, unit: ProcessSpec) -> dict[str, Rights]:
    """Return the bus users that a process needs, and their rights: those that its rows wire, and no others."""
    users = {sharing.user(unit.name, unit.config.process): of_process(plan, unit)}
    if unit.lan is not None:
        users[unit.lan.link.user] = _of_lan(plan, unit)
    return users


def of_local(plan: Plan) -> Rights:
    """Return the rights of any user of the robot's socket, without a password: to look, and to operate.

    The user may publish setpoints, but their receiver refuses them with a report, as they lack the seal; streams may
    not be published. Permitted keys are listed one by one: a wildcard would also permit every other wildcard, and with
    it all that a row denies.
    """
    robot = plan.robot
    return Rights(
        put=(*_command_keys(plan), keys.estop(robot)),
        ask=(
            f"{robot}/**",
            keys.console(robot, "view"),
            keys.console(robot),
            keys.estop(robot),
            keys.estop_reset(robot),
            keys.router(robot, "*"),
            *keys.looked_at(robot),
        ),
        hear=(f"{robot}/**", keys.estop(robot), keys.estop_acknowledgement(robot, "*"), *keys.looked_at(robot)),
        watch=(keys.alive(robot, "*"),),
    )


def looked_at(plan: Plan) -> tuple[str, ...]:
    """Return what is only looked at: a failed query can be repeated, and delays nothing."""
    return (*plan.streams(), *keys.looked_at(plan.robot))


def _command_keys(plan: Plan) -> Iterable[str]:
    """Return every key on which a capability accepts commands or setpoints, even if its row is off now."""
    kinds = plan.kinds.items()
    declared = {keys.port(plan.robot, name, port) for name, kind in kinds for port in (*kind.commands, *kind.setpoints)}
    running = {keys.port(plan.robot, name, command) for name in plan.units for command in plan.commands(name)}
    return sorted((declared | running) - set(plan.streams()))


def of_process(plan: Plan, unit: ProcessSpec) -> Rights:
    """Return the rights of a process, on another machine at the door there: what its rows wire, and nothing else."""
    config, robot, name = unit.config, plan.robot, unit.name
    outputs = tuple(wire.key for wires in config.outputs.values() for wire in wires)
    inputs = tuple(wire.key for wires in config.wiring.values() for wire in wires)
    commands = (*(keys.port(robot, name, command) for command in plan.commands(name)), keys.edit(robot, name))
    requests = tuple(key for asked in config.requests.values() for key in asked.values())
    relayed = _relayed(unit.lan.commands, robot) if unit.lan is not None else ()
    watched = (keys.status(robot),) if unit.lan is not None else ()
    people = _for_people(robot) if unit.serves_people else _to_record(robot) if unit.records else Rights()
    acknowledgement = (keys.estop_acknowledgement(robot, name),) if unit.moves else ()
    release = (keys.estop_release(robot, name),) if unit.moves else ()
    return Rights(
        put=(*outputs, *relayed, *acknowledgement, keys.event(robot), keys.taped(robot, name), keys.estop(robot)),
        ask=(*requests, *inputs, *relayed, *people.ask),
        serve=(
            *outputs,
            *commands,
            *release,
            keys.event(robot),
            keys.taped(robot, name),
            keys.schema(robot, name, "*"),
        ),
        hear=(*inputs, *commands, *release, *watched, *people.hear, keys.estop(robot)),
        alive=(keys.alive(robot, name),),
        watch=(keys.alive(robot, "*"),),
    )


def _for_people(robot: str) -> Rights:
    """Return the rights of a server for people: to look at everything, to send any command and any line in their names.

    They are wildcards, so that an edit can add a capability without new rights. No wildcard matches keys with an `@`.
    """
    consoles = tuple(keys.console_of_pages(robot, role) for role in get_args(Role))
    return Rights(
        ask=(f"{robot}/**", *consoles, keys.status(robot), keys.manage(robot)),
        hear=(f"{robot}/**", keys.status(robot), keys.event(robot)),
    )


def _to_record(robot: str) -> Rights:
    """Return the rights of a recorder: to receive all streams and lines, and to ask for description and pictures."""
    return Rights(
        ask=(f"{robot}/*/frame", keys.console(robot, "view")),
        hear=(f"{robot}/**", keys.status(robot), keys.event(robot), keys.taped(robot, "*")),
    )


def _of_lan(plan: Plan, unit: ProcessSpec) -> Rights:
    """Return the rights of other machines without the relay: to look, and to stop.

    The robot's processes there also publish without it; only their requests to others are relayed. Permitted
    subscriptions are listed key by key: all others that a client declares end at the door, and delay no other router.
    """
    assert unit.lan is not None
    robot, lan = plan.robot, unit.lan
    guests = [guest.rights for guest in lan.guests]
    agents = [keys.agent_alive(robot, user.name) for user in lan.users if user.role == "host"]
    asked = {key for rights in guests for key in rights.ask} - set(lan.commands)
    return Rights(
        put=(*lan.stops, keys.estop(robot), *_all(rights.put for rights in guests)),
        ask=(
            *lan.stops,
            *lan.streams,
            keys.estop(robot),
            *keys.looked_at(robot),
            keys.host(robot, "*"),
            *sorted(asked),
        ),
        serve=_all(rights.serve for rights in guests),
        hear=(*lan.subscribed, *_all(rights.hear for rights in guests), keys.estop(robot), *keys.looked_at(robot)),
        alive=(*_all(rights.alive for rights in guests), *agents),
        watch=(keys.alive(robot, "*"),),
    )


def _all(allowed: Iterable[tuple[str, ...]]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(key for some in allowed for key in some))


def _relayed(commands: Iterable[str], robot: str) -> tuple[str, ...]:
    consoles = tuple(keys.console(robot, role) for role in ("view", "operate", "admin"))
    return (*commands, *consoles, keys.estop_reset(robot))
