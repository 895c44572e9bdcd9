"""`docksignal left|right|power`: tells the robot that another program has seen a beam of its dock.

For receivers that the kernel does not know: a daemon that runs a program on each code, a script, a person.
"""
