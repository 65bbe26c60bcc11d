"""YAML and JSON -> plain data and models, with every fault at its line.

faults       what is wrong with a file: FILE:LINE: KEY: what is wrong, what was expected
document     YAML -> plain data that remembers its lines
json_text    JSON -> plain data that remembers its lines
schema       plain data -> a pydantic model, or every fault at once
units        units that are mixed up
file_lookup  names in configs/ -> files
"""
