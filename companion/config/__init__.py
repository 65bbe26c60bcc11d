"""Files people write -> frozen, validated values. All unit and frame conversion of human input happens here.

faults      what is wrong with a file: FILE:LINE: KEY: what is wrong, what was expected
document    YAML -> plain data that remembers its lines
schema      plain data -> a pydantic model, or every fault at once
places      names in configs/ -> files
vehicle     vehicle files
world       world files (keys: world_keys, event_keys)
mission     mission files (keys: path_keys, profile_keys, fence_keys; curves, profiles, along: what they mean)
earth       latitude and longitude in mission files -> metres
json_text   JSON -> plain data that remembers its lines
plan_files  QGroundControl's .plan, and waypoint_files the older .waypoints -> plans
plan_mission, plan_yaw      a plan -> the path, speed and heading of a mission; plan_source finds its file
units       units that are mixed up
published   the JSON Schemas; examples: files to begin from
"""
