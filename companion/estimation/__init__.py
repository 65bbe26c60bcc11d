"""What the vehicle does not say: where it will be when a command acts.

prediction   a rigid body advanced by a short time
"""
