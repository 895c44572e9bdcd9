"""Borrowing motion: one holder, leases that expire, offers to senders elsewhere, stops.

Pure for every kind of motion, except `client`, `holder` and `over_session`, which borrow it. The process around a
kernel is `lbr.operations.lender`. A kernel keeps a `LeaseTable` in its state (`lease.first`), with its own phrasing.
Each `Lease` has the kernel's own motion, with goal and bounds. Every incoming command becomes a `LeaseRequest`. Then:

- before every event: `ending.lapse` ends a lease that was not renewed, `ending.lose_time` ends all leases
  if the clock went back;
- a command: `ask.resolve` makes an `Ask`: the intent, the quoted lease, and the time of sending on our clock. The
  kernel's chain of checks refuses it or not. `form`, `holder` and `at_rest` of `rules` are the first of them. Then come
  `decide.refuse`, `decide.renew` or `decide.stop`. For an "offer", a "change" or a "begin", the kernel makes a motion
  and grants it by `decide.grant`. `decide.accepted` is the answer, `decide.with_motion` keeps the progress;
- `decide.latch` for the emergency stop, and `ending.end` for a motion that is over by itself or by a fault.

All return the new lease table and its reports. Each `Ended` is a lease whose motion is over: the kernel reports the end
of its goal. `Happened` is for people. Every reason is a `Reason`: a code for programs and a sentence.
"""
