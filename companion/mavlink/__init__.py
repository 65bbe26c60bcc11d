"""The wire: MAVLink 2 as values. Nothing here knows about flying, sockets or clocks.

dialect     the messages: names, fields, wire formats, CRC extras (pymavlink's tables and the few it lacks)
codec       bytes <-> frames
modes       PX4's flight modes and landed states in HEARTBEAT, CURRENT_MODE and EXTENDED_SYS_STATE
telemetry   frames -> VehicleState and VehicleStatus
setpoints   Setpoint -> the values of its message
link        who the vehicle is, heartbeats, time synchronisation
requests    what is asked of it: commands with acknowledgement and retry, stream intervals
"""
