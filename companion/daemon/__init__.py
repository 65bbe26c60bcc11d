"""The only room with sockets and clocks.

conductor        one flight without either: datagrams and the time in, datagrams out
orders           what is to be flown, as ordered before the vehicle is known
preparing        orders and a vehicle -> a plan, or why it is not flown
asked_of_vehicle what is asked of the vehicle, as MAVLink commands
tick             what the last tick saw and did
state_count      how many states the vehicle sends
ground           what a ground station sees of us, and may set
payload          the payload's commands on the link
loop             the conductor on a real link in real time, and the one place that catches what escapes a turn
last_resort      what is done then
scribe           the two threads beside it: the record, the screen
signals          what Ctrl-C and its like do to a flight
vehicle_words    where the vehicle is and what to do next, for whoever ended a flight by hand

port, address    udpin://, udpout:// and serial:// -> a port to read and write; serial: one device
beside           PX4's XRCE client beside the MAVLink link
forwarding       the link for others: ground stations and programs at UDP endpoints
endpoints        the process that has their sockets
key_giving       a vehicle is given its signing key; signing_files: the time stamps, which outlive us

progress         what a person watching sees
status_file      the same for other terminals; live: and for the live page
systemd          the same for systemd

realtime         what makes the control thread punctual, as far as the system permits
priority         what of a batch of datagrams must be taken in first
rhythm           when the next state will come
warm_up          the last tick once more before that, so that the caches are warm
"""
