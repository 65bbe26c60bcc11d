"""The evidence of a flight, and what is made of it afterwards.

tlog      every frame in both directions, as ground stations and log tools read it
table     one row a tick, one named column a quantity: what the pilot saw and what it did
folder    the flight folder: both of these, the resolved configuration, the summary
series    the followed part as one array a quantity: as believed, and as it truly was
summary   the figures of a flight
replay    the recorded inputs through the pilot again
report    the page one shows to others
"""
