#!/usr/bin/env python3
"""A numpy quilt on the panel: 8 x 6 views, from blue on the left to red on the right. View 0 is at the bottom left."""
import numpy

import quiltd

view = 8 * (5 - numpy.arange(6 * 80) // 80)[:, None] + (numpy.arange(8 * 60) // 60)[None, :]
quilt = numpy.stack([view * 5, view * 0, 255 - view * 5], axis=-1).astype("uint8")
q = quiltd.show_quilt(quilt, columns=8, rows=6)
print("shown: generation", q.wait("coarse", timeout=60)["generation"])
