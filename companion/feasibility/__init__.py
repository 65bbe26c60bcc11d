"""What a mission will ask of a vehicle, before it flies.

stations     places along a path: the path, the speed and the yaw there, with their derivatives over arc length
demand       what is asked at each: thrust, tilt, body rates, torques, motors (the exact reference, with drag)
limits       how much of each limit that uses
geometry     limits of the path itself: bends, height, how it closes
report       the answer: worst values, where, how fast at most
words        .. for a person    document  .. as JSON    picture  .. to look at
headroom     what is left of the limits at a speed
auto         `speed: auto` made into a speed
fastest      .. how: the search
arc_spline   a quintic spline over arc length, linear in its coefficients
"""
