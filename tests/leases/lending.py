"""A lender at the wire, as a lease client asks it."""

from lbr.messages.leases import CommandReply


class Question:
    def __init__(self, answer):
        self.answer = answer

    def answers(self):
        return self.answer


class Drive:
    """What answers: yes with a lease, as told, or not at all."""

    def __init__(self):
        self.now = 10.0
        self.asked = []
        self.reply = None
        self.mute = self.absent = False

    def clock(self):
        return self.now

    def ask(self, request, message, timeout_s):
        self.asked.append((request, message))
        if self.mute:
            return Question(None)
        if self.absent:
            return Question({})
        if self.reply is not None and request == "go":
            return Question({"drive": self.reply})
        return Question({"drive": CommandReply(accepted=True, lease="L1", ttl_s=0.3, goal="goal-1")})

    @property
    def sent(self):
        return [message for request, message in self.asked if request == "go"]

    @property
    def halts(self):
        return [message for request, message in self.asked if request == "halt"]
