"""Study files: what is flown many times, what varies, what is required of it (``keys``)."""
