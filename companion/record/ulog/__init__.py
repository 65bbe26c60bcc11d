"""The vehicle's own log (ULog) beside our record of the same flight.

topics    which of PX4's topics are taken, column by column
reading   a .ulg file -> those topics as arrays (needs the library ``pyulog``, extra ulog)
clock     the offset of the log's clock from the stamps of the states, by the body rates that both hold
joined    the topics on the clock of the states; kept in the flight folder as ulog.npz
"""
