"""Ground stations' plans as values: what QGroundControl and MAVProxy write, and what of it is a path.

items       a plan: its items, home, fence; item_place: where an item says to fly
payload     what cameras, grippers and servos do where it comes to a waypoint
areas       fences that stand among the items
scan        a structure scan, which a .plan does not write out, as items
waypoints   the waypoints of a route, as values
route       items -> waypoints in the order they are flown, with the speed and the heading of each leg
rest        what of a plan comes after the end of its path, in words
writing     a plan -> the text of a .plan
"""
