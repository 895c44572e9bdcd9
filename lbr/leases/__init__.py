"""Borrowing motion: one holder, leases that lapse, offers to senders elsewhere, stops.

Pure, whatever it is that moves, but for `client`, `holder` and `over_session`, by which motion is borrowed. The process
around a kernel is `lbr.operations.lender`. A kernel keeps a `LeaseTable` in its state (`lease.first`), with its own
phrasing and, in each `Lease`, its own motion (goal, bounds, whatever it needs); it makes a `LeaseRequest` of every
command that comes in. Then:

- before every event: `ending.lapse` ends what was not renewed, or `ending.lose_time` everything if the clock went back;
- a command: `ask.resolve` makes an `Ask` of it: what it wants, which lease it quotes, when it was sent on our clock. The
  kernel's chain, which has `form`, `holder` and `at_rest` of `rules` before its own, says whether that is refused. Then
  it is `decide.refuse`, `decide.renew` or `decide.stop`; of an "offer", a "change" or a "begin" the kernel makes a
  motion and has it by `decide.grant`. `decide.accepted` is the answer, `decide.with_motion` keeps how far it has come;
- `decide.latch` for the emergency stop, and `ending.end` for a motion that is over by itself or by a fault.

All return the new lease table and what is to be said of it: each `Ended` is a lease whose motion is over, so that the
kernel says how its goal ended; `Happened` is for people. Every reason is a `Reason`: a code for programs and a
sentence.
"""
