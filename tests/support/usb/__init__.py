"""USB devices played to the kernel of this machine, whose own drivers then bind to them: no hardware, no network.

`usbip` and `descriptors` are codecs, `device` plays one device at the end of a socket, `vhci` plugs that socket in. What is
behind a device, a line or a bus, is an emulated device of lbr's.
"""
