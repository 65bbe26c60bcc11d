"""The stand-in PX4: everything between a MAVLink message and a motor command.

parameters    the figures a user may set, under PX4's names
autopilot     one step: estimate in, motor commands out
commander/    armed or not, which mode, what to do when something is wrong: PX4's commander
flight_modes/ what each mode flies: PX4's navigator and flight mode manager
missions/     missions, geofences, rally points: the protocol, what is refused, what is flown
logger/       the vehicle's own log
mavlink/      one endpoint: bytes in, bytes out; streams, parameters, files
messages/     what the vehicle says, message by message
commands/     what it answers to commands
xrce/         PX4's uxrce_dds_client: its topics to and from an agent
"""
