#!/usr/bin/env python3
"""Turns the camera once around its target: orbit.py [DEGREES PER STEP]"""
import sys

import quiltd

step = float(sys.argv[1]) if len(sys.argv) > 1 else 10
with quiltd.connect() as q:
    for _ in range(round(360 / step)):
        q.orbit(yaw=step)
        print("generation", q.wait("coarse", timeout=60)["generation"])
