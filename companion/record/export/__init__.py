"""A flight folder as files that other programs open.

columns     columns as text, a line a row: their units, their numbers
channels    the flight as named series over time, for MCAP
schemas     the JSON schemas of those, and of Foxglove's own that are used
scene       the path, what was flown and the vehicle as lines to look at
mcap_writer the messages of an MCAP file, all at once
mcap_file   one MCAP file (needs the extra ``log``)
csv_files   one CSV file a table, and a legend
ulog_series PX4's own log beside them
"""
