#!/usr/bin/env python3
"""A numpy mesh on the panel: a fluted vase of 80 x 80 vertices."""
import numpy

import quiltd

u, y = (axis.ravel() for axis in numpy.mgrid[0 : 2 * numpy.pi : 80j, -1:1:80j])
radius = 0.5 + 0.15 * numpy.cos(4 * y) + 0.04 * numpy.cos(9 * u)
points = numpy.stack([radius * numpy.cos(u), y, radius * numpy.sin(u)], axis=-1)
a = (80 * numpy.arange(79)[:, None] + numpy.arange(79)).ravel()
faces = numpy.concatenate([numpy.stack([a, a + 1, a + 80], axis=-1), numpy.stack([a + 1, a + 81, a + 80], axis=-1)])
q = quiltd.show(mesh=(points, faces), normals="smooth", material={"albedo": [0.1, 0.4, 0.6]})
print("shown:", q.wait("complete", timeout=60)["level"])
