"""The robot's own API: what it is, its streams, its commands, its console, and motion held from a page.

    GET  /api                          what the robot is                     catalog.py
    GET  /api/<capability>/<stream>    its newest message, and how old       requests.py
    POST /api/<capability>/<command>   the command, and its reply            requests.py
    POST /api/console                  a console line                        requests.py
    WS   /api/live                     newest of streams, events, a hold     live.py ─► feeds.py, holds.py

The WebSockets are on the server's thread. Askers and the renewal of leases are in the capability's loop, which never
waits for a client; between them are slots that one writes and the other reads.
"""
