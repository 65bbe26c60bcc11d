"""Where: curves in space, by a formula, by points, or as the zero set of two functions; each ends as a table over arc
length.

implicit, tracing      h1 = h2 = 0 (Definition 3.1), and once around it
parametrisation        what every gamma(u) answers: formula, piecewise, round, lissajous, polyline, spline
curve                  a path given by one
measuring              from the parameter to arc length and back
arc                    the table: nearest point, distance, length
placement              where a mission's coordinates stand in the vehicle's local frame
"""
