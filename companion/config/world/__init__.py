"""World files.

world       the file as a whole -> a simulated world
keys        what it may say; actor_keys: who acts in it
event_keys  what may happen in it; link_event_keys: to datagrams, event_times: when
"""
