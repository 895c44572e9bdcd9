"""The song of a dance, played by speech: its beginning, and whether it goes on. Without sound it begins at once."""

from msgspec import Struct

from lbr.capability.context import Context
from lbr.messages.codes import Reason
from lbr.messages.speech import HushCommand, PlayReply, SongCommand, SpeechState

ANSWER_S = 1.0
PLAUSIBLE_S = 3.0
NEAR_THE_END_S = 0.5


class Music:
    """One song. `began` is None until it is known; `silent` is why there is no sound, or empty."""

    def __init__(self, ctx: Context[Struct], song: str, duration_s: float) -> None:
        self.began: float | None = None
        self.silent = ""
        self._ctx = ctx
        self._song = song
        self._duration_s = duration_s
        self._asked = ctx.ask("sound", SongCommand(song=song), ANSWER_S)

    def step(self) -> None:
        """Read when the song began."""
        answers = self._asked.answers() if self.began is None else None
        if answers is None:
            return
        now = self._ctx.clock()
        reply = next((each for each in answers.values() if isinstance(each, PlayReply)), None)
        self.began = now
        if reply is None:
            self.silent = "speech does not answer" if answers else "no channel leads from 'sound' to speech"
        elif not reply.accepted:
            self.silent = reply.reason or "speech refused it"
        elif reply.began_s is not None and now - PLAUSIBLE_S <= reply.began_s <= now:
            self.began = reply.began_s

    def cut(self) -> Reason | None:
        """Return why the song ended before its time, or None."""
        if self.began is None or self.silent:
            return None
        if not self._ctx.clock() < self.began + self._duration_s - NEAR_THE_END_S:
            return None
        sources = self._ctx.sources("speech")
        if sources and not any(self._ctx.alive(source) for source in sources):
            return Reason("unreachable", "speech is gone, and the song with it")
        told = self._ctx.latest("speech")
        if told is None or told.arrived < self.began or not isinstance(told.message, SpeechState):
            return None
        return None if told.message.playing == self._song else Reason("stopped", "the song was ended")

    def stop(self) -> None:
        """End the song, even one that may begin later because speech did not answer in time."""
        self._ctx.ask("hush", HushCommand(song=self._song), ANSWER_S)
