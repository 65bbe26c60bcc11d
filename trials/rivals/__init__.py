"""The others, on equal terms: what flies the same courses as the law, and the places it is flown in.

course         what is flown: a mission and, for a tracker, the same path as a function of time
tracker        a time-tracking geometric SE(3) controller behind the steering seam, with the law's estimator
px4_position   PX4's own position control with full feed-forward, over MAVLink
rotorpy_place  RotorPy's simulator: its own controller in it, and ours
plant_place    the project's own plant in lockstep, under any steering
ablation       the law's steering without one of its remedies
figures        from a flown track to the numbers of a table
sorties        one flight of a table
drawing        the figure of docs/rivals.md
"""
