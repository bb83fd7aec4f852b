#!/usr/bin/env python3
"""Saves one image per direction, turn_00.png and so on: turntable.py [NUMBER]"""
import pathlib
import sys

import quiltd

number = int(sys.argv[1]) if len(sys.argv) > 1 else 8
with quiltd.connect() as q:
    for i in range(number):
        pathlib.Path(f"turn_{i:02}.png").write_bytes(q.export("still", wait="complete", timeout=600))
        q.orbit(yaw=360 / number)
