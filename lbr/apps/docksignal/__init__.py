"""`docksignal left|right|power`: reports a beam of the dock that another program has received.

For receivers that the kernel does not know: a daemon that runs a program on each code, a script, a person.
"""
