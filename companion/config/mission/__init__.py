"""Mission files.

mission       the file as a whole
path_keys     the kinds of path; curves: what they mean
profile_keys  speed and yaw; profiles: what they mean; along: what only following the path shows
fence_keys    where the vehicle may be
gains         poles, or the gains themselves
earth         latitude and longitude -> metres
"""
