#!/usr/bin/env python3
"""Explores a volume by a threshold, as a contour plot does: each line that you type hides all values below it."""
import sys

import numpy

import quiltd

z, y, x = numpy.mgrid[-3:3:64j, -3:3:64j, -3:3:64j]
field = numpy.abs(numpy.sin(x * y) * numpy.cos(y * z)) * numpy.exp(-(x * x + y * y + z * z) / 4)
with quiltd.connect() as q:
    for line in sys.stdin:
        q.show(numpy.where(field > float(line), field, 0).astype("float32"), spacing=1 / 32, scale=40)
        print("shown:", q.wait("coarse", timeout=60)["level"])
