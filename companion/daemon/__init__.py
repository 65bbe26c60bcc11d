"""The only room with sockets and clocks.

conductor   one flight without either: datagrams and the time in, datagrams out
loop        the conductor on a real link in real time
address     udpin://, udpout:// and serial:// -> a port to read and write
progress    what a person watching sees
standing    the same from another terminal
"""
