"""Borrowing motion: one holder, leases that lapse, offers to senders elsewhere, stops. Pure, whatever it is that moves.

A kernel keeps a `Holding` in its state (`state.first`), with its own words and, in each `Hold`, its own motion (goal,
bounds, whatever it needs); it makes an `Ask` of every command that comes in. Then:

- before every event: `ending.lapse` ends what was not renewed, or `ending.lose_time` everything if the clock went back;
- a command: `acceptance.intent` says what is wanted. A "stop" is `holding.stop`. Anything else passes the links `form`,
  `holder` and `at_rest` of `acceptance`, and the kernel's own after them; one that objects makes it `refuse`.
  Then, all in `holding`, a "renewal" is `renew`, a "change" is `change`, and the rest `begin`, or `offer` if the ask is
  `remote` and the intent "new"; `with_motion` keeps how far the motion has come;
- `holding.latch` for the emergency stop, and `ending.end` for a motion that is over by itself or by a fault.

All but the links return the new holding and what is to be said of it: each `Ended` is a hold whose motion is over, so
that the kernel says how its goal ended; `Happened` is for people. The answer to a command is `accepted` or `refuse`'s.
"""
