#!/usr/bin/env python3
"""A numpy volume on the panel: a soft ring."""
import numpy

import quiltd

z, y, x = numpy.mgrid[-1:1:64j, -1:1:64j, -1:1:64j]
ring = numpy.exp(-40 * ((numpy.hypot(x, y) - 0.6) ** 2 + z**2))
q = quiltd.show(ring.astype("float32"), spacing=1 / 32, albedo=[1, 0.8, 0.6])
print("shown:", q.wait("complete", timeout=60)["level"])
