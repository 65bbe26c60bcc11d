"""One MAVLink endpoint of the vehicle: bytes in, bytes out.

link            what arrives, handed to whom it concerns; what is sent
streams         when it says what
stream_table    PX4's streams and their rates
parameter_link  the parameter protocol
setpoint_link   the setpoints that come over it
signing         one key for all links
file_link       files over MAVLink
files           the files there are
boot_messages   what is said unasked at boot
"""
