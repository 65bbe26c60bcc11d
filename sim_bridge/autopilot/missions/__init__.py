"""Missions, geofences and rally points: taken in over MAVLink, kept, checked, flown.

items      one item: from the wire, to the wire, its share in the list's id; item_table: of each command
store      the three lists and which mission item is current
mission_messages  what is said of them
protocol   the mission protocol on one link
checks     what PX4 refuses to fly
fence      inside or outside
flight     the items one after another
mission_watch  the mission beside its flight
do_commands    what a mission orders besides flying somewhere
"""
