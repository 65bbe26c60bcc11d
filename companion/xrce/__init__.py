"""DDS-XRCE as the agent that PX4's ``uxrce_dds_client`` connects to, without sockets or clocks, without DDS or ROS.

messages    what holds a session together, one value each, with its bytes
objects     what a client makes, asks for and publishes, likewise
wire        bytes <-> messages of such values
reliable    streams on which each message comes once and in order
agent       the conversation with one client
topics      samples of PX4's topics: layout and MESSAGE_VERSION
commands    the gate before setpoints; command_message: setpoint -> the bytes of its message
flight_mode a flight mode of our own
framing     messages <-> a serial line
"""
