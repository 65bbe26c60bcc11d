"""The vehicle's own log, as PX4's logger writes it.

ulog     the file format
logger   what is logged, how often, and from when to when
"""
