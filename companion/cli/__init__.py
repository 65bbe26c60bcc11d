"""The commands. Heavy parts are imported when a command needs them.

simulate   a mission against the plant: in lockstep, or as two processes over UDP
flying     a mission on a vehicle
status     what the companions on this computer are doing
bare       the law without a vehicle, state by state
export     a mission as a plan or a table; export_flight a flight for other programs
new        examples of every kind of file, and their schemas
around     what every flight is wrapped in: record, signals
finish     what every flight ends with: summary, folder, report, exit code
terminal   stdout and stderr, which cannot hold up a flight or end it
"""

from companion.cli.commands import main

__all__ = ["main"]
