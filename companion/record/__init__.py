"""The evidence of a flight, and what is made of it afterwards.

place          where a flight folder may be, and what of it is ours to remove
folder         the flight folder: all that follows, the notes, the resolved configuration (resolution), the summary
circumstances  the simulated world it was flown in
growing        a file that grows in flight: bounded, never in the way, read up to where it was cut
files          files that others read while we write: whole or not at all
owned_files    small files in places that others can write to
tlog           every frame in both directions, as ground stations and log tools read it; xrce_log: every datagram
table          rows of named columns in a file; tick_columns: those of a tick, what the pilot saw and what it did
rows           a tick as such a row, and back
ticks          the same in memory, where nobody asked for a folder
learned        what a vehicle's last flight found out, for its next one

recorded       a flight folder read again
replay         the recorded inputs through the pilot again
series         the followed part as one array a quantity: as believed, and as it truly was
events         what happened to the flight, and what it did about it
final_estimates what it found out of its vehicle
summary        the figures of a flight
ulog/          PX4's own log on the clock of our states
report/        the page one shows to others
export/        what other programs open
"""
