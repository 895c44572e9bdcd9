"""One device shadow: its reported and desired state. Pure: driven by its messages and the time.

    connected ──► get ──► get/accepted: version, reported, desired ──► the desire
    delta ─────► get again, as a delta has only the differences, and may be older than the known version
    report() ──► update of what changed in `reported`, under the known version, every 5 s at most
                 update/rejected 409: another client was first ──► get again

`desired` is never written. A request is reported back unchanged, beside the answer, so that the two states agree.
"""

from collections.abc import Iterator
from math import inf
from typing import NamedTuple

import msgspec

from lbr.apps.mqtt import documents
from lbr.apps.mqtt.report import Report, difference, merged
from lbr.errors import InputError

ANSWER_S = 10.0
"""The wait for an answer of the service."""
AGAIN_S = 1.0
"""The shortest pause between two gets, whatever the rate of deltas."""
REJECTED_S = 30.0
LARGEST_ECHO = 512
CONFLICT, NOT_THERE = 409, 404
_SUBSCRIBED = ("get/accepted", "get/rejected", "update/accepted", "update/rejected", "update/delta")


class Desire(NamedTuple):
    """The desire of a shadow: any JSON value, and its age (None: unknown)."""

    raw: object
    age_s: float | None


class ShadowState:
    """A shadow's state since the last connection; `version` is None before the first answer."""

    def __init__(self, thing: str, name: str, every_s: float, mark: str) -> None:
        self.root = f"$aws/things/{thing}/shadow" + (f"/name/{name}" if name else "")
        self.version: int | None = None
        self._every_s = every_s
        self._mark = mark
        self._count = 0
        self._known: Report = {}
        self._handled: bytes | None = None
        self._wanted = True
        self._get = ("", -inf)
        self._update: tuple[str, float, Report] = ("", -inf, {})
        self._next_get = self._next_update = -inf

    @property
    def topics(self) -> tuple[str, ...]:
        """The topics to subscribe to."""
        return tuple(f"{self.root}/{one}" for one in _SUBSCRIBED)

    def connected(self) -> None:
        """Forget the state, as the shadow may have changed meanwhile; desires that were done stay done."""
        self.version, self._known, self._wanted = None, {}, True
        self._get, self._update, self._next_get = ("", -inf), ("", -inf, {}), -inf

    def receive(self, topic: str, payload: bytes, now: float) -> Desire | None:
        """Handle a message of a subscribed topic; return its desire, if any. Raise InputError for a bad message."""
        document = documents.read(payload)
        match topic.removeprefix(f"{self.root}/"):
            case "update/delta":
                if self.version is None or documents.version_of(document) > self.version:
                    self._wanted = True
            case "get/accepted":
                return self._fetched(document)
            case "get/rejected":
                self._not_fetched(documents.answer(document), now)
            case "update/accepted":
                self._updated(documents.answer(document))
            case "update/rejected":
                self._not_updated(documents.answer(document), now)
        return None

    def publish(self, report: Report, now: float) -> Iterator[tuple[str, bytes]]:
        """Yield the topics and payloads to send now."""
        if self._wanted and now >= self._next_get and not now - self._get[1] < ANSWER_S:
            self._get, self._next_get, self._wanted = (self._token(), now), now + AGAIN_S, False
            yield f"{self.root}/get", msgspec.json.encode({"clientToken": self._get[0]})
        elif self._get[0] and not now - self._get[1] < ANSWER_S:
            self._get, self._wanted = ("", -inf), True
        waits = bool(self._update[0]) and now - self._update[1] < ANSWER_S
        if self.version is None or waits or now < self._next_update:
            return
        change = difference(self._known, report)
        if not change:
            return
        self._update, self._next_update = (self._token(), now, change), now + self._every_s
        update = {"state": {"reported": change}, "version": self.version, "clientToken": self._update[0]}
        if self.version == 0:
            del update["version"]  # a shadow that does not exist yet has no version
        yield f"{self.root}/update", msgspec.json.encode(update)

    def done(self, raw: object) -> object:
        """Note that a desire was answered; return the value to report: the desire itself, unless it is too long."""
        self._handled = _text(raw)
        return raw if len(self._handled) <= LARGEST_ECHO else "too long to be told"

    def _fetched(self, fields: dict[str, object]) -> Desire | None:
        if fields.get("clientToken") != self._get[0] or not self._get[0]:
            return None  # another client's get
        self._get = ("", -inf)
        document = documents.document(fields)
        if self.version is not None and document.version < self.version:
            raise InputError(f"its version is {document.version}, and {self.version} was there before", "repeated")
        self.version, self._known = document.version, document.reported
        if document.ask is None or _text(document.ask) in {self._handled, _text(document.reported.get("ask"))}:
            return None
        return Desire(document.ask, document.age_s)

    def _not_fetched(self, answer: documents.Answer, now: float) -> None:
        if answer.token != self._get[0] or not self._get[0]:
            return
        self._get = ("", -inf)
        if answer.code == NOT_THERE:
            self.version, self._known = 0, {}
            return
        self._wanted, self._next_get = True, now + REJECTED_S
        raise InputError(f"the shadow cannot be had: {answer.code} {answer.text}".strip(), "refused")

    def _updated(self, answer: documents.Answer) -> None:
        token, _sent, change = self._update
        if answer.token != token or not token:
            return
        self._update = ("", -inf, {})
        if answer.version is None or (self.version is not None and answer.version <= self.version):
            self._wanted = True
            raise InputError(f"its version is {answer.version}, and {self.version} was there before", "repeated")
        self.version, self._known = answer.version, merged(self._known, change)

    def _not_updated(self, answer: documents.Answer, now: float) -> None:
        if answer.token != self._update[0] or not self._update[0]:
            return
        self._update, self._wanted = ("", -inf, {}), True
        if answer.code != CONFLICT:
            self._next_update = now + REJECTED_S
            raise InputError(f"the shadow was not updated: {answer.code} {answer.text}".strip(), "refused")

    def _token(self) -> str:
        self._count += 1
        return f"{self._mark}-{self._count}"


def _text(value: object) -> bytes:
    """Encode a JSON value, equal values as equal bytes."""
    return msgspec.json.encode(value, order="sorted")
