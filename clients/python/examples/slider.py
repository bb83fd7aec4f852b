#!/usr/bin/env python3
"""A slider for the vertical angle of the camera: each line that you type is an angle in degrees."""
import sys

import quiltd

with quiltd.connect() as q:
    for line in sys.stdin:
        q.camera.set(fov_y=float(line))
        print("shown:", q.wait("complete", timeout=60)["level"])
