"""Files people write -> frozen, validated values. All unit and frame conversion of human input happens here.

syntax/       YAML and JSON -> plain data that remembers its lines; faults, units, where a name's file is
mission/      mission files: path, speed, heading, fence, gains
plan/         plans of ground stations -> missions
world/        world files
study/        study files
vehicle       vehicle files
json_schemas  the JSON Schemas of them all
examples      files to begin from
signing_key   the key of a signed link
"""
