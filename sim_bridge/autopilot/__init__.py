"""The stand-in PX4: everything between a MAVLink message and a motor command.

parameters  the figures a user may set, under PX4's names
commander   armed or not, which mode, what to do when something is lost: no I/O, no physics
failsafe    what to do when something is wrong: PX4's state machine
causes      what can go wrong, and what the parameters ask for then
contacts    who has been heard lately
sticks      a pilot's sticks
stick_flight  what the modes that need a pilot fly
battery     how full it is
fact_watch  the facts these decide by, kept up to date
tilt_watch  whether the vehicle has tipped over
landing     whether the vehicle is on the ground
setpoints, position_setpoints   offboard setpoints as PX4 reads them
offboard    what is flown of a place or a velocity
guidance    what the automatic modes fly
missions/   missions, geofences, rally points: the protocol, what is refused, what is flown
mission_watch, orders   the mission beside its flight
fence_watch whether the vehicle is where it may be
orbit       flying round a point
heading     the turning of the nose
autopilot   one step: estimate in, motor commands out
messages    what the vehicle says, message by message
streams     when it says it
commands    what it answers to commands
events      what is said in numbers beside the texts
event_table what the events mean, for ground stations
health_report  in which modes it could be armed and flown, and why not
greeting    what is said unasked at boot
file_link   files over MAVLink
link        one endpoint: bytes in, bytes out
"""
