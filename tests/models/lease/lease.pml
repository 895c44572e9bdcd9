/* The lease: clients, the drive's decision, the driver's decision, the controller's watchdog, and what may go wrong between.
 *
 * `spin -a lease.pml && cc -O2 -DSAFETY -o pan pan.c && ./pan`, or `python -m benchmarks lease`, which also takes the times
 * below from lbr itself. Time goes in ticks; all that happens within one tick happens at one time. Every date is kept as
 * an age, which stops growing once it makes no difference any more, so that the states are finitely many.
 *
 * Client 0 is on the robot. Client 1 is, too, or (REMOTE) on another machine: then lbr cannot read its clock.
 * One message and one setpoint at a time may be astray: late, lost, doubled, overtaken by any number that go straight.
 * Lines that begin with @ are what a replay needs. What is only here to be proved begins with `g_`.
 */

#ifndef LATE
#define LATE 3      /* oldest command that moves anything: LATE_S */
#define LEASE 4     /* ticks that a lease lives without renewal: ttl_s less what it ends ahead */
#define OFFER 4     /* ticks that an offer waits for its confirmation: ttl_s */
#define INSIST 3    /* ticks that a sender who insisted has to pause: PERSISTENT_S */
#define VALID 2     /* ticks that a setpoint is in force: setpoint_valid_s */
#define WATCHDOG 3  /* ticks until the controller stops by itself: watchdog_ms */
#endif
#ifdef CHOSEN       /* when the search begins, by the environment */
byte bug;
bit remote, taking, estop, crashes, insisting;
#define REMOTE remote
#define TAKING taking
#define ESTOP estop
#define CRASHES crashes
#define INSISTING insisting
#else
#ifndef REMOTE
#define REMOTE 0    /* client 1 is on another machine */
#endif
#ifndef TAKING
#define TAKING 1    /* clients may ask to take over */
#endif
#ifndef ESTOP
#define ESTOP 1     /* the emergency stop may be pressed and reset */
#endif
#ifndef CRASHES
#define CRASHES 1   /* the drive and the driver may die, hang and begin anew */
#endif
#ifndef INSISTING
#define INSISTING 1 /* who insists is noticed; without it more is accepted, so that what holds then holds with it, too */
#endif
#ifndef BUG
#define BUG 0       /* which seeded error there is; none */
#endif
#define bug BUG
#endif

#define OLD (LATE + (REMOTE -> OFFER : 1))
#define NEVER (LATE + 1)                                  /* the age of what never was */
#define LIMIT (LATE + LEASE + OFFER + VALID + WATCHDOG)
#define OLDEST_SETPOINT (VALID - 1 + WATCHDOG - 1)
#define FIRST_WORD (LATE + LEASE - 1)                     /* of a motion that was never renewed, when it last moves */
#define LAST_WORD (LEASE - 1 + (REMOTE -> OFFER - 1 : 0)) /* of one that was */
#define BOUND (FIRST_WORD > LAST_WORD -> FIRST_WORD : LAST_WORD)

/* leases, as messages quote them */
#define NONE 0
#define HELD 1
#define OFFERED 2
#define DEAD 3

/* seeded errors */
#define B_EXTENDS 1
#define B_REPLAY 2
#define B_STOP_KEEPS 3
#define B_STOP_FORGETS 4
#define B_KEEPS_SETPOINT 5
#define B_FEEDS 6
#define B_NOT_NEUTRAL 7
#define B_RESUMES 8
#define B_OLD_LEASE 9
#define B_REUSED 10
#define B_ARRIVAL 11
#define B_NO_HOLDER 12
#define B_INSISTING 13
#define B_TRUSTS_AFAR 14
#define B_OVERTAKES 15
#define B_RESTART 16
#define B_UNORDERED 17
#define B_OLD_ZERO 18

/* the message astray */
bit m_used, m_src, m_mv, m_tk;
byte m_lease, m_age;
bit g_m_pre, g_m_done, g_m_gone;
/* the message that is being decided */
bit c_src, c_mv, c_tk, c_ok, c_copy;
byte c_lease, c_age, c_date, c_offs;
bit g_c_pre, g_c_done, g_c_gone;
/* what clients know: the lease they were given last; at first one that died long ago */
byte know[2] = DEAD;
bit g_know_gone[2] = 1;

/* the drive's decision */
bit h_held, h_src, h_mv, h_quoted;     /* who holds the base, and whether it is to move */
byte h_said, h_since, h_offs;          /* when that was said; since when the lease lives; the least delay seen */
bit o_made, o_tk;                      /* the offer to the client on another machine */
byte o_age, o_offs;
byte k_stop = NEVER, k_begun = NEVER;  /* what was sent before these begins nothing */
byte k_insists[2];                     /* LATE more than the ticks that the sender has yet to pause: see PAUSES */
bit k_latched, k_armed, k_wheels, k_told;
bit g_h_pre, g_h_old, g_h_lapsed;
byte g_word, g_insists[2];

/* the setpoint astray */
bit s_used, s_mv, s_held, s_dead;
byte s_age;
bit g_s_pre, g_s_old;

/* the driver's decision, and the controller */
bit d_up = 1, d_armed, d_mv, d_held, d_same, d_hdead, d_inhibited, d_latched;
byte d_age, d_since = VALID;
bit g_d_pre, g_d_old;
bit motor;
byte fed;
byte g_motor;
bit g_rested;                          /* the driver was told zero since */
byte g_what;                           /* what came last: 3 a stop or a pause, 6 a restart, 7 the emergency stop */

bit pressed;
byte g_broken;

/* within one event */
mtype = { nothing, time_runs, time_hangs, tick, speaks, strays, comes, comes_twice, is_lost, setpoint_comes, hears,
          drive_begins, driver_dies, driver_begins, is_pressed, drive_latches, driver_latches, is_reset };
mtype event = nothing;
bit decides, says, runs, learns;       /* the drive decides; says a setpoint; the driver's loop goes round; an answer arrives */
byte way;                              /* of that setpoint: 0 straight, 1 astray, 2 lost */
bit r_comes, r_mv, r_held, r_dead, g_r_pre, g_r_old;
byte r_age;                            /* the setpoint that comes in at the driver */

#define FAIL(n) g_broken = n; printf("@ violated %d\n", n); assert(g_broken != n)
#define MUST(n, holds) if :: (holds) :: else -> FAIL(n) fi
#define MIN(a, b) ((a) < (b) -> (a) : (b))
#define OLDER(age, most) age = ((age) < (most) -> (age) + 1 : (most))
#define YOUNGER(age) age = ((age) > 0 -> (age) - 1 : 0)
/* Whether the sender has paused, counted from what it sent to what it sends: a message astray was sent earlier. */
#define PAUSES(insists, date) (insists[c_src] + (date) <= LATE)
#define INSISTS(insists, date) insists[c_src] = (insists[c_src] + (date) > LATE + INSIST -> insists[c_src] : LATE + INSIST - (date))
#define AFAR(client) (REMOTE && (client) == 1)

/* ---- the drive ---- */

#define STAYS (bug == B_REUSED || (bug == B_OLD_LEASE && c_ok))

inline lease_dies(which) {
  if :: m_used && m_lease == which -> m_lease = (STAYS -> which : DEAD); g_m_gone = 1 :: else fi;
  if :: c_lease == which -> c_lease = (STAYS -> which : DEAD); g_c_gone = 1 :: else fi;
  if :: know[0] == which -> know[0] = (STAYS -> which : DEAD); g_know_gone[0] = 1 :: else fi;
  if :: know[1] == which -> know[1] = (STAYS -> which : DEAD); g_know_gone[1] = 1 :: else fi
}

inline offer_is_over() { o_made = 0; o_tk = 0; o_age = 0; o_offs = 0 }

inline drop_offer() {
  if :: o_made -> lease_dies(OFFERED); offer_is_over() :: else fi
}

/* the lease that was offered is the one held from now on */
inline offer_is_held() {
  if :: m_used && m_lease == OFFERED -> m_lease = HELD :: else fi;
  if :: know[0] == OFFERED -> know[0] = HELD :: else fi;
  if :: know[1] == OFFERED -> know[1] = HELD :: else fi;
  offer_is_over()
}

inline next_wheels() {
  k_wheels = h_held && h_mv && (k_wheels || !k_told);
  k_told = 1; says = 1
}

/* nobody holds the base any more, and it is told to stand still */
inline end_hold() {
  lease_dies(HELD);
  h_held = 0; h_src = 0; h_mv = 0; h_quoted = 0; h_said = 0; h_since = 0; h_offs = 0;
  g_h_pre = 0; g_h_old = 0; g_h_lapsed = 0;
  s_held = 0; d_held = 0; d_hdead = 0;
  k_wheels = 0; k_told = 1; says = 1
}

/* before every event: what is over by now ends */
inline end_what_is_over() {
  if :: !k_armed || o_age >= OFFER -> drop_offer() :: else fi;
  g_h_lapsed = h_held && h_since >= LEASE;
  if :: h_held && (!k_armed || (g_h_lapsed && (bug != B_EXTENDS || event == tick))) -> end_hold() :: else fi
}

/* nothing said before this, under the lease `only` if it is one, may move it: `what` is the property, `since` the age */
inline nothing_from_before(what, since, only) {
  g_what = what;
  if :: m_used && m_age >= since && (only == NONE || m_lease == only) -> g_m_pre = 1 :: else fi;
  g_h_pre = h_held && h_mv; g_s_pre = s_used && s_mv; g_d_pre = d_armed && d_mv;
  g_rested = 0
}

inline end_all(keep) {
  drop_offer();
  if :: h_held && !(keep) -> end_hold() :: else -> k_wheels = 0; k_told = 1; says = 1 fi
}

#define STREAMS (h_held && h_src == c_src && !h_quoted && c_lease == NONE)
#define NEWEST (h_quoted && (bug != B_OVERTAKES || c_mv == h_mv) && h_since < h_said -> h_since : h_said)
#define MAY_HOLD ( \
  c_lease == DEAD -> 0 : \
  (c_lease == HELD -> (AFAR(c_src) && c_src != h_src && c_mv -> 0 : !c_mv || bug == B_REPLAY || c_date < NEWEST) : \
  (h_held && ((!c_tk && !(c_lease == OFFERED && o_tk) && bug != B_NO_HOLDER) || STREAMS) -> 0 : \
  (k_latched || c_date < k_stop) && (bug == B_REPLAY || c_date < k_begun))))
#define AT_REST (!c_mv || (!k_latched && k_armed && PAUSES(k_insists, c_date)))

/* when a message was sent at the latest, as far as the drive can tell; a stop from afar counts from when it came */
inline date_it() {
  c_offs = (!AFAR(c_src) -> 0 : (c_lease == HELD && h_src == c_src -> MIN(h_offs, c_age) : (c_lease == OFFERED -> MIN(o_offs, c_age) : c_age)));
  c_date = (bug == B_ARRIVAL -> 0 : c_age - c_offs)
}

inline quote() {
  h_since = (h_quoted -> MIN(h_since, c_date) : c_date);
  h_quoted = 1;
  h_offs = (AFAR(c_src) && h_src == c_src -> c_offs : h_offs);
  g_word = MIN(g_word, c_age)
}

inline begin() {
  if
  :: h_held ->
     MUST(4, h_src == (c_lease == OFFERED -> 1 : c_src) || c_tk || (c_lease == OFFERED && o_tk));
     c_ok = 1;
     end_hold()
  :: else
  fi;
  h_held = 1; h_mv = c_mv; h_said = c_date; k_begun = MIN(k_begun, c_date);
  if
  :: c_lease == OFFERED -> h_src = 1; h_quoted = 1; h_since = c_date; h_offs = (c_src == 1 -> c_offs : o_offs); offer_is_held()
  :: else -> h_src = c_src; h_quoted = 0; h_since = 0; h_offs = 0
  fi;
  g_word = c_age
}

inline accept() {
  if
  :: c_mv && (c_lease != NONE || !AFAR(c_src)) ->
     MUST(2, !g_c_gone && !(c_lease == HELD && g_h_lapsed));
     MUST(7, PAUSES(g_insists, c_age));
     MUST(8, !g_c_done)
  :: else
  fi;
  if
  :: c_lease == HELD ->
     if :: !c_mv -> nothing_from_before(3, c_age, HELD) :: else fi;
     quote();
     if
     :: c_mv == h_mv -> g_h_pre = g_h_pre || (c_mv && g_c_pre)
     :: else -> h_mv = c_mv; h_said = MIN(h_said, c_date); g_h_pre = c_mv && g_c_pre; g_h_old = 0; next_wheels()
     fi
  :: c_lease == NONE && AFAR(c_src) && bug != B_TRUSTS_AFAR ->
     drop_offer();
     o_made = 1; o_tk = c_tk; o_offs = c_offs
  :: else -> begin(); g_h_pre = c_mv && g_c_pre; g_h_old = 0; next_wheels()
  fi;
  c_ok = 1
}

inline refuse() {
  if
  :: c_mv && ((k_latched && c_date <= k_stop) || STREAMS || !PAUSES(k_insists, c_date)) && INSISTING && bug != B_INSISTING -> INSISTS(k_insists, c_date)
  :: else
  fi;
  if :: c_mv && ((k_latched && c_age <= k_stop) || !PAUSES(g_insists, c_age)) -> INSISTS(g_insists, c_age) :: else fi
}

inline command() {
  date_it();
  if
  :: c_lease == NONE && !c_mv ->
     nothing_from_before(3, c_date, NONE);
     k_stop = (bug == B_STOP_FORGETS -> k_stop : MIN(k_stop, c_date));
     k_insists[c_src] = 0; g_insists[c_src] = 0;
     end_all(bug == B_STOP_KEEPS);
     c_ok = 1
  :: else ->
     if
     :: (!c_mv || c_date <= LATE) && MAY_HOLD && AT_REST -> accept()
     :: else -> refuse()
     fi
  fi
}

#define LEARNABLE (c_ok && ((c_mv && c_lease == NONE) || c_lease == OFFERED))

/* the answer reaches the client */
inline learn() {
  printf("@ learns\n");
  know[c_src] = (c_lease == NONE && AFAR(c_src) && bug != B_TRUSTS_AFAR -> OFFERED : HELD); g_know_gone[c_src] = 0
}

/* ---- the driver ---- */

inline forget_setpoint() { s_used = 0; s_mv = 0; s_held = 0; s_dead = 0; s_age = 0; g_s_pre = 0; g_s_old = 0; d_same = 0 }

/* the drive says a setpoint */
inline say() {
  printf("@ setpoint %d %d\n", k_wheels, way);
  MUST(5, !k_wheels || g_word <= (h_quoted -> LAST_WORD : FIRST_WORD));
  if
  :: way == 0 ->
     g_rested = g_rested || !k_wheels;  /* from now on the driver knows */
     if :: bug != B_UNORDERED -> forget_setpoint() :: else fi;
     r_comes = 1; r_mv = k_wheels; r_held = k_wheels; r_dead = k_wheels && d_hdead; g_r_pre = k_wheels && g_h_pre; g_r_old = k_wheels && g_h_old
  :: way == 1 ->
     s_used = 1; s_mv = k_wheels; s_held = k_wheels; s_dead = k_wheels && d_hdead; d_same = k_wheels && d_held;
     g_s_pre = k_wheels && g_h_pre; g_s_old = k_wheels && g_h_old
  :: else
  fi
}

inline disarm() {
  if :: d_armed && d_mv -> d_hdead = d_hdead || d_held; s_dead = s_dead || d_same :: else fi;
  d_armed = 0; d_mv = 0; d_held = 0; d_same = 0; d_age = 0; g_d_pre = 0; g_d_old = 0; d_since = 0
}

/* a setpoint comes in */
inline receive() {
  if
  :: r_age < VALID && !(r_mv && r_dead) && (d_armed || ((!r_mv || bug == B_NOT_NEUTRAL) && !d_inhibited && r_age < d_since)) ->
     d_armed = 1; d_mv = r_mv; d_age = (r_mv -> r_age : 0); d_held = r_held; g_d_pre = g_r_pre; g_d_old = g_r_old;
     d_same = r_mv && s_used && s_mv && s_held && r_held
  :: else
  fi;
  r_comes = 0; r_mv = 0; r_age = 0; r_held = 0; r_dead = 0; g_r_pre = 0; g_r_old = 0
}

/* the driver's loop goes round: it looks for reasons to stop, then writes to the controller */
inline drive_motors() {
  if
  :: d_latched || fed >= VALID ->
     if :: d_armed || !d_inhibited -> disarm() :: else fi;
     d_inhibited = 1; d_since = 0
  :: else ->
     if :: d_armed && d_mv && d_age >= VALID && bug != B_KEEPS_SETPOINT -> disarm() :: else fi;  /* a zero stays */
     d_inhibited = 0
  fi;
  motor = d_armed && d_mv; fed = 0;
  g_motor = (!motor -> 0 : (d_age >= VALID && g_motor > d_age -> g_motor : d_age));
  if
  :: motor ->
     MUST(1, g_motor < VALID);
     if :: g_d_pre && g_rested -> FAIL(g_what) :: else fi;
     MUST(6, !g_d_old);
     MUST(7, !d_latched)
  :: else
  fi
}

/* ---- what nobody decides ---- */

inline no_message() {
  m_used = 0; m_src = 0; m_mv = 0; m_tk = 0; m_lease = 0; m_age = 0; g_m_pre = 0; g_m_done = 0; g_m_gone = 0
}

inline time_passes() {
  OLDER(m_age, (m_used -> OLD : 0));
  if
  :: m_used && m_age >= OLD && !(AFAR(m_src) && m_lease == NONE) -> no_message()  /* it moves nothing any more */
  :: else
  fi;
  OLDER(h_said, (h_held -> NEVER : 0)); OLDER(h_since, (h_held -> LEASE : 0));
  OLDER(o_age, (o_made -> OFFER : 0)); OLDER(k_stop, NEVER); OLDER(k_begun, NEVER);
  YOUNGER(k_insists[0]); YOUNGER(k_insists[1]); YOUNGER(g_insists[0]); YOUNGER(g_insists[1]);
  k_told = 0;
  OLDER(s_age, (s_used -> VALID : 0));
  if :: s_used && s_age >= VALID && bug != B_UNORDERED -> forget_setpoint() :: else fi;
  OLDER(d_age, (d_armed && d_mv -> VALID : 0)); OLDER(d_since, VALID); OLDER(fed, WATCHDOG);
  OLDER(g_motor, (motor -> LIMIT : 0)); OLDER(g_word, LIMIT);
  if
  :: motor && bug == B_FEEDS -> fed = 0
  :: motor && bug != B_FEEDS && fed >= WATCHDOG -> motor = 0; g_motor = 0
  :: else
  fi
}

inline begin_drive() {
  nothing_from_before(6, 0, NONE);
  drop_offer(); end_hold();
  k_stop = (bug == B_RESTART -> NEVER : 0); k_begun = NEVER;
  k_insists[0] = 0; k_insists[1] = 0; g_insists[0] = 0; g_insists[1] = 0;
  k_latched = pressed; k_armed = 0
}

inline begin_driver() {
  d_up = 1; d_since = (bug == B_OLD_ZERO -> VALID : 0); d_latched = pressed; fed = 0; motor = 0; g_motor = 0;
  g_h_old = h_held && h_mv; g_s_old = s_used && s_mv
}

/* An age that only says whether the message astray was sent before something: any other that says the same will do.
 * Not so where the date of a message depends on how quick others were. */
#define ORDER(age, matters) age = ((age) == 0 || (REMOTE && m_used && m_src) -> (age) : (m_used && (matters) && m_age >= (age) -> m_age : NEVER))

/* A pause that is over for what is sent now: it only says whether the message astray was sent in it. */
#define STILL(insists, client) insists[client] = (insists[client] > LATE || AFAR(client) -> insists[client] : \
  (m_used && m_mv && m_src == client && insists[client] + m_age > LATE -> LATE : 0))

inline forget_what_makes_no_difference() {
  ORDER(k_stop, true); ORDER(k_begun, true);
  STILL(k_insists, 0); STILL(k_insists, 1); STILL(g_insists, 0); STILL(g_insists, 1);
  if :: h_held && !(REMOTE && h_src) -> ORDER(h_said, m_lease == HELD) :: else fi;
  if :: d_since > 0 && (!s_used || s_age < d_since) -> d_since = VALID :: else fi;
  if :: !(g_m_pre || g_h_pre || g_s_pre || g_d_pre) -> g_rested = 0; g_what = 0 :: else fi;
  if :: !(motor || h_held || s_mv || d_mv) -> g_word = 0 :: else fi
}

inline check() {
  MUST(1, !motor || g_motor <= OLDEST_SETPOINT);
  MUST(5, !motor || g_word <= BOUND + OLDEST_SETPOINT);
  forget_what_makes_no_difference();
#ifdef REACH
  assert(!(REACH));
#endif
  printf("@ state %d %d %d %d %d %d\n", h_held, h_held && h_src, h_held && h_mv, k_wheels, d_armed, motor)
}

inline happen() {
  if
  :: event == time_runs -> printf("@ time 1\n"); time_passes(); runs = d_up
  :: event == time_hangs -> printf("@ time 0\n"); time_passes()
  :: event == tick -> printf("@ tick\n"); decides = 1
  :: event == speaks -> printf("@ says %d %d %d %d\n", c_src, c_lease, c_mv, c_tk); decides = 1
  :: event == strays ->
     printf("@ astray %d %d %d %d\n", c_src, c_lease, c_mv, c_tk);
     m_used = 1; m_src = c_src; m_mv = c_mv; m_tk = c_tk; m_lease = c_lease; g_m_gone = g_c_gone
  :: event == comes || event == comes_twice ->
     printf("@ comes %d\n", event == comes_twice);
     c_src = m_src; c_mv = m_mv; c_tk = m_tk; c_lease = m_lease; c_age = m_age;
     g_c_pre = g_m_pre; g_c_done = g_m_done; g_c_gone = g_m_gone;
     decides = 1; c_copy = (event == comes_twice);
     if :: event == comes -> no_message() :: else fi
  :: event == is_lost -> printf("@ lost\n"); no_message()
  :: event == setpoint_comes ->
     printf("@ setpoint_comes\n");
     r_comes = 1; r_mv = s_mv; r_age = s_age; r_held = s_held; r_dead = s_dead; g_r_pre = g_s_pre; g_r_old = g_s_old;
     if :: bug != B_UNORDERED -> forget_setpoint() :: else fi
  :: event == hears -> printf("@ hears %d\n", !k_armed); decides = 1
  :: event == drive_begins -> printf("@ drive_begins\n"); begin_drive()
  :: event == driver_dies ->
     printf("@ driver_dies\n");
     disarm(); d_up = 0; d_inhibited = 0; d_hdead = 0; s_dead = 0; d_latched = 0
  :: event == driver_begins -> printf("@ driver_begins\n"); begin_driver(); runs = 1
  :: event == is_pressed -> printf("@ pressed\n"); pressed = 1
  :: event == drive_latches -> printf("@ drive_latches %d\n", pressed); decides = 1
  :: event == driver_latches -> printf("@ driver_latches %d\n", pressed); d_latched = pressed; runs = 1
  :: event == is_reset -> printf("@ reset\n"); pressed = 0
  fi
}

inline decide() {
  end_what_is_over();
  if
  :: event == tick -> next_wheels()
  :: event == hears ->
     k_armed = !k_armed;
     if :: !k_armed && h_held -> end_all(0) :: !k_armed && !h_held -> drop_offer() :: else fi
  :: event == drive_latches ->
     nothing_from_before(7, 0, NONE);
     k_latched = pressed; k_stop = 0;
     end_all(bug == B_RESUMES)
  :: else ->
     command();
     printf("@ verdict %d\n", c_ok);
     g_m_done = g_m_done || (c_copy && c_ok)
  fi
}

inline forget_event() {
  event = nothing; decides = 0; says = 0; runs = 0; learns = 0; way = 0;
  c_src = 0; c_mv = 0; c_tk = 0; c_ok = 0; c_copy = 0; c_lease = 0; c_age = 0; c_date = 0; c_offs = 0;
  g_c_pre = 0; g_c_done = 0; g_c_gone = 0
}

/* a client says something: new motion, taking over, motion or standing still under its lease, or a stop */
inline speak() {
  if :: c_src = 0 :: c_src = 1 fi;
  if
  :: c_mv = 1
  :: TAKING -> c_mv = 1; c_tk = 1
  :: c_mv = 1; c_lease = know[c_src]
  :: c_lease = know[c_src]
  :: true
  fi;
  g_c_gone = c_lease != NONE && g_know_gone[c_src];
  if :: event = speaks :: !m_used -> event = strays fi
}

active proctype world() {
#ifdef CHOSEN
  c_code {
    const char *chosen = getenv("LEASE");
    for (; chosen && *chosen; chosen++)
      switch (*chosen) {
        case 'r': now.remote = 1; break;
        case 't': now.taking = 1; break;
        case 'e': now.estop = 1; break;
        case 'c': now.crashes = 1; break;
        case 'i': now.insisting = 1; break;
        default: now.bug = 10 * now.bug + *chosen - '0';
      }
  };
#endif
  do
  :: atomic {
       if
#ifdef WALK          /* a history drawn by chance is to see something move; spin draws the first for each that cannot be */
       :: speak()
       :: event = tick
       :: event = tick
       :: !k_armed && d_up && d_armed -> event = hears
       :: !k_armed && d_up && d_armed -> event = hears
       :: !h_held && k_armed -> c_mv = 1; event = speaks
       :: h_held -> c_src = h_src; c_mv = 1; c_lease = know[c_src]; event = speaks
       :: h_held -> c_src = h_src; c_mv = 1; c_lease = know[c_src]; event = speaks
       :: pressed != k_latched -> event = drive_latches
       :: d_up && pressed != d_latched -> event = driver_latches
       :: pressed && k_latched && d_latched -> event = is_reset
       :: o_made -> c_src = 1; c_mv = 1; c_lease = know[c_src]; event = speaks
#endif
       /* time passes; the driver's loop goes round, or hangs */
       :: event = time_runs
       :: CRASHES -> event = time_hangs
       /* the drive's loop goes round; that it hangs is that this does not happen */
       :: event = tick
       :: speak()
       /* the message astray comes in, for the first time or once more; or it is lost */
       :: m_used && m_age > 0 -> if :: event = comes :: event = comes_twice fi
       :: m_used -> event = is_lost
       /* the setpoint astray comes in */
       :: s_used && d_up && s_age > 0 -> event = setpoint_comes
       /* the drive hears that the driver is armed; or that it is not, is silent or gone */
       :: k_armed || (d_up && d_armed) -> event = hears
       /* the drive dies, and begins with zero; the driver dies; it begins, with zero */
       :: CRASHES -> event = drive_begins
       :: CRASHES && d_up -> event = driver_dies
       :: !d_up -> event = driver_begins
       /* the emergency stop: pressed, heard by each, and reset once both have heard */
       :: ESTOP && !pressed && !k_latched && !d_latched -> event = is_pressed
       :: pressed != k_latched -> event = drive_latches
       :: d_up && pressed != d_latched -> event = driver_latches
       :: pressed && k_latched && (d_latched || !d_up) -> event = is_reset
       fi;
       d_step { happen(); if :: decides -> decide() :: else fi };
       if :: LEARNABLE -> learns = 1 :: true fi;
       if :: says && d_up :: says && !s_used && VALID > 1 -> way = 1 :: says -> way = 2 :: else fi;
       d_step {
         if :: learns -> learn() :: else fi;
         if :: says -> say() :: else fi;
         if :: r_comes -> receive(); runs = 1 :: else fi;
         if :: runs -> drive_motors() :: else fi;
         forget_event();
         check()
       }
     }
  od
}
