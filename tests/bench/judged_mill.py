"""The mill that corpus.py and peer.py measure with: three axes with the same limits."""
VELOCITY, ACCELERATION = 500.0, 2000.0  # mm/s, mm/s²
TOLERANCE = 0.01  # mm


def machine_file(name, jerk):
    """@param jerk mm/s³; 1e12: not limited"""
    return f"""[machine]
name = "{name}"
profile = "fanuc-0i-m"
period_us = 1000
[path]
tolerance_mm = {TOLERANCE}
[drive]
type = "ideal"
""" + "".join(f"""[axis.{axis}]
rapid_mm_min = {VELOCITY * 60}
max_feed_mm_min = {VELOCITY * 60}
max_acceleration_mm_s2 = {ACCELERATION}
max_jerk_mm_s3 = {jerk}
min_mm = -5000
max_mm = 5000
""" for axis in "XYZ")
