"""Plans of ground stations -> missions.

qgroundcontrol  QGroundControl's .plan -> plans
waypoints       the older .waypoints -> plans
polygons        Mission Planner's polygons and fences, which are no path
source          where the plan of a mission is; a plan in the place of a mission file
to_mission      a plan -> the path, speed and fence of a mission; yaw: its heading, corners: what can be flown
room        corners that a short leg leaves no room
"""
