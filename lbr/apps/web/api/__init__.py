"""The robot's own API: its description, streams, commands and console, and motion held from a page.

    GET  /api                          the robot's description               catalog.py
    GET  /api/<capability>/<stream>    its newest message, and the age       requests.py
    POST /api/<capability>/<command>   the command, and its reply            requests.py
    POST /api/console                  a console line                        requests.py
    WS   /api/live                     newest of streams, events, a hold     live.py ─► feeds.py, holds.py

The WebSockets run on the server's thread. Requests and the renewal of leases run in the capability's loop, which never
waits for a client. Between the two are slots: one side writes, the other reads.
"""
