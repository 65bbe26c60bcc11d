"""The commands. Heavy parts are imported when a command needs them.

commands   the commands that fly; file_, look_, record_, study_ and vehicle_commands: the others
options    what several commands take; output: their choices
check      what a mission will ask of a vehicle, before anything flies
simulate   a mission against the plant: in lockstep, or as two processes over UDP
story      a simulated flight told while it goes on; demo: the flight that shows what the law is for
flying     a mission on a vehicle
status     what the companions on this computer are doing; watch: the live page
preflight  the vehicle's parameters before a flight
vehicle_making a vehicle file of what PX4 says and of a log; vehicle_showing: beside what flights found
bare       the law without a vehicle, state by state
export     a mission as a plan or a table; export_flight: a flight for other programs; writing: never over another file
new        examples of every kind of file, and their schemas
around     what every flight is wrapped in: record, signals
finish     what every flight ends with: summary, folder, report (page), PX4's log (vehicle_log), exit code
terminal   stdout and stderr, which cannot hold up a flight or end it; study_progress: a bar
"""

from companion.cli.commands import main

__all__ = ["main"]
