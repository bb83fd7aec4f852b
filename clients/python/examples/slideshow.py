#!/usr/bin/env python3
"""Shows what is in a folder that quiltd may read, in turn: slideshow.py FOLDER [SECONDS]"""
import os
import sys

import quiltd

seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 10
with quiltd.connect() as q:
    q.playlist.set(folder=os.path.abspath(sys.argv[1]), seconds=seconds)
    print("shown in turn:", len(q.playlist.play()["entries"]))
