"""Motions by their numbers and names, as in the remote control and the API."""

from collections.abc import Iterable

from lbr.apps.web.face import Refused
from lbr.messages.faces import Button
from lbr.robots.uxa90.rest.answers import MotionData, MotionMessage, PlayedAnswer
from lbr.robots.uxa90.rest.number import begins_as_integer, number

LARGEST = 1e6


class ButtonTable:
    """The rows of `button`, by number."""

    def __init__(self, buttons: Iterable[Button]) -> None:
        self.buttons = {button.id: button for button in sorted(buttons, key=lambda each: each.id)}

    def put(self, button: Button) -> None:
        """Add a new or changed button."""
        self.buttons[button.id] = button
        self.buttons = dict(sorted(self.buttons.items()))

    def find(self, key: str) -> tuple[Button, bool]:
        """Return the button for a number or a name, and whether it was a number; the first of several with one name."""
        if by_id := begins_as_integer(key):
            wanted_id = number(key)
            button = self.buttons.get(int(wanted_id)) if wanted_id.is_integer() and abs(wanted_id) < LARGEST else None
        else:
            wanted = key.lower()
            button = next((button for button in self.buttons.values() if button.name.lower() == wanted), None)
        if button is None:
            raise Refused(409, "Motion doesn't exist", code="unknown_name")
        return button, by_id

    def all(self) -> list[MotionData]:
        """Return all as data of the API."""
        return [data(button) for button in self.buttons.values()]


def data(button: Button) -> MotionData:
    """Return one as data of the API."""
    return MotionData(id=button.id, name=button.name, button=button.button)


def played(button: Button, *, by_id: bool) -> PlayedAnswer:
    """Return the answer for one that plays from now on."""
    message = MotionMessage(btn_code=button.id) if button.motion else MotionMessage(motion_name=button.name)
    return PlayedAnswer(data(button), "callMotionById" if by_id else "callMotionByName", message)
