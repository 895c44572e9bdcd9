"""The contents of a package for lbr: the object behind its entry point in the group `lbr.components`.

    [project.entry-points."lbr.components"]
    my_arm = "my_arm:COMPONENT"                                         # in its pyproject.toml

    COMPONENT = Component(kinds={"my_arm": "my_arm.kind:KIND"}, …)      # in my_arm/__init__.py

Every process may import the object's module, so that imports nothing else. The targets of its strings are imported only
where they are used.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

CommandGroup = Literal["start", "drive", "look", "change", "build", "run for good"]
COMMAND_GROUPS: tuple[CommandGroup, ...] = get_args(CommandGroup)
"""The headings of `lbr --help`, in their order."""


@dataclass(frozen=True, slots=True)
class CliCommand:
    """A command of the command line; `entry` is a `click.Command`, as `module:attribute`.

    `help` and `group` are its line and heading in `lbr --help`. The heading of other packages is the package's name.
    """

    entry: str
    help: str
    group: CommandGroup | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class Component:
    """Its contents by name, each as `module:attribute`.

    - `kinds`: a `Kind` of capability, by its name.
    - `commands`: commands of the command line, by name.
    - `faces`: faces of the HTTP server, by name; `ports` is the `FacePorts` of the face of that name.
    - `robots`: a `Robot`, by its name.
    - `twins`: a `DeviceTwin`, by the type that device rows name.
    - `checks`: checks of `lbr doctor` for each robot, by name: a function of the robot's name and its capability
      rows that yields `lbr.commands.finding.Finding`.
    - `messages`: modules of message types that other components may import; `public`: other such modules and packages.
    - `needs`: components that some of its parts import. A part does not load without them, and its error names the
      missing one.
    """

    kinds: Mapping[str, str] = field(default_factory=dict)
    commands: Mapping[str, CliCommand] = field(default_factory=dict)
    faces: Mapping[str, str] = field(default_factory=dict)
    ports: Mapping[str, str] = field(default_factory=dict)
    robots: Mapping[str, str] = field(default_factory=dict)
    twins: Mapping[str, str] = field(default_factory=dict)
    checks: Mapping[str, str] = field(default_factory=dict)
    messages: tuple[str, ...] = ()
    public: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
