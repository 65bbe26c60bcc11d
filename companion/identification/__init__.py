"""A vehicle file without a scale and a lathe: from what PX4 knows, and from a log of a flight.

description   the keys of a vehicle file, each with where its value is from; written as commented YAML
parameters    PX4's parameters -> a description; quadrotor: what vehicle they are of
ulog          a log -> arrays; flight_data: what of it was flown, on one grid
rate_fit      the rate loops, what torque does, the motors' lag
force_fit     hover thrust, drag, thrust curve, battery; least_squares: of both fits
from_log      all of that -> a description; what a better log would need
picture       the fit drawn over what was seen
"""
