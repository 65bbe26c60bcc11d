"""The wire: MAVLink 2 as values. Nothing here knows about flying, sockets or clocks.

dialect     the messages: names, fields, wire formats, CRC extras (pymavlink's tables and the few it lacks)
codec       bytes <-> frames
modes       PX4's flight modes and landed states in HEARTBEAT, CURRENT_MODE and EXTENDED_SYS_STATE
telemetry   frames -> VehicleState and VehicleStatus
setpoints   Setpoint -> the values of its message
link        who the vehicle is, heartbeats, time synchronisation
peer        who is our vehicle among all that speaks; counters: what was seen, repeats: what came twice
clock       its clock by ours
requests    what is asked of it: commands with acknowledgement and retry, stream intervals
parameters  its parameters, read by name, set and set back
upload      a list of mission items to it
announcing  what a ground station sees of us; own_parameters: what it may set
signing     frames signed and checked; key_setup: a vehicle is given the key
"""
