"""The evidence of a flight, and what is made of it afterwards.

growing   a file that grows in flight: bounded, never in the way, read up to where it was cut
files     files that others read while we write: whole or not at all
place     where a flight folder may be, and what of it is ours to remove
tlog      every frame in both directions, as ground stations and log tools read it
table     one row a tick, one named column a quantity: what the pilot saw and what it did
folder    the flight folder: both of these, the notes, the resolved configuration (resolution), the summary
series    the followed part as one array a quantity: as believed, and as it truly was
summary   the figures of a flight
replay    the recorded inputs through the pilot again
report    the page one shows to others
"""
