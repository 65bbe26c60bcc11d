"""What each mode flies.

guidance            what the automatic modes fly
orbit               flying round a point
heading             the turning of the nose
manual_control      a pilot's sticks
manual              what the modes that need a pilot fly
setpoints, position_setpoints   offboard setpoints as PX4 reads them
offboard            what is flown of a place or a velocity
topics              what is written to its own topics over XRCE
"""
