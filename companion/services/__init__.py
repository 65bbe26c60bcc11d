"""Off the control path: what is looked at and set up before a flight, by MAVSDK.

audit       parameters of a vehicle -> what is set, what we advise and why; pure
vehicle     a vehicle over MAVSDK: its parameters, its rates, its place; geofence and curve uploaded
log_files   its own log of the last flight
plan_check  a plan read by us and by MAVSDK's own reader
"""
