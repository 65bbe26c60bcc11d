"""Files people write -> frozen, validated values. All unit and frame conversion of human input happens here.

faults      what is wrong with a file: FILE:LINE: KEY: what is wrong, what was expected
document    YAML -> plain data that remembers its lines
schema      plain data -> a pydantic model, or every fault at once
places      names in configs/ -> files
vehicle     vehicle files
world       world files (keys: world_keys, event_keys)
mission     mission files
"""
