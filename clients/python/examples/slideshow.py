#!/usr/bin/env python3
"""Shows what is in a folder that quiltd may read, in turn: slideshow.py FOLDER [SECONDS]"""
import os
import sys

import quiltd

seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 10
with quiltd.connect() as q:
    found = q.library.list(folder=os.path.abspath(sys.argv[1]))["entries"]
    kinds = ("scene", "model", "volume", "quilt", "image")
    q.playlist.set([{"file": entry["path"], "seconds": seconds} for entry in found if entry["kind"] in kinds])
    print("shown in turn:", len(q.playlist.play()["entries"]))
