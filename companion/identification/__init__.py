"""A vehicle file without a scale and a lathe: from what PX4 knows, and from a log of a flight.

description   the keys of a vehicle file, each with where its value is from; written as commented YAML
parameters    PX4's parameters -> a description
"""
