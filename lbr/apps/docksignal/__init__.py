"""`docksignal left|right|power`: reports a beam of the dock, which another program has seen, to the robot.

For receivers that the kernel does not know: a daemon that runs a program on each code, a script, a person.
"""
