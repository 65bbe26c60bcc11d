"""Where a mission is: from what it counts from to the local frame of the vehicle that flies it.

origins     home, take-off point, a place on the earth -> the vehicle's local NED frame
drawn       a mission as a ground station's plan
listed      a mission as a table
words       where a path runs, in sentences for the pilot
"""
