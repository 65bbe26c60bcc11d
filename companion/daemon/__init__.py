"""The only room with sockets and clocks.

conductor     one flight without either: datagrams and the time in, datagrams out
loop          the conductor on a real link in real time, and the one place that catches what escapes a turn
last_resort   what is done then
scribe        the two threads beside it: the record, the screen
signals       what Ctrl-C and its like do to a flight
vehicle_words where the vehicle is and what to do next, for whoever ended a flight by hand
address       udpin://, udpout:// and serial:// -> a port to read and write
progress      what a person watching sees
status_file   the same for other terminals
priority      what of a batch of datagrams must be taken in first
warm_up       the last tick once more, so that the caches are warm: rhythm says when
"""
