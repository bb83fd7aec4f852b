#!/usr/bin/env python3
"""Turns the camera of a running quiltd and takes the quilt as a PNG: client.py SOCKET OUT.png"""
import array, json, os, socket, sys

class Quiltd:
    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(path)
        self.lines = self.socket.makefile("r", encoding="utf-8")
        self.ids = 0

    def call(self, method, params={}, descriptors=[]):
        self.ids += 1
        call = {"jsonrpc": "2.0", "id": self.ids, "method": method, "params": params}
        line = json.dumps(call).encode() + b"\n"
        rights = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", descriptors))]
        sent = self.socket.sendmsg([line], rights if descriptors else [])
        self.socket.sendall(line[sent:])
        return self.receive(lambda message: message.get("id") == self.ids)["result"]

    def receive(self, wanted):
        for line in self.lines:
            message = json.loads(line)
            if "error" in message:
                sys.exit("client.py: " + message["error"]["message"])
            if wanted(message):
                return message
        sys.exit("client.py: quiltd closed the connection")

quiltd = Quiltd(sys.argv[1])
generation = quiltd.call("camera.orbit", {"yaw": 10})["generation"]
quiltd.call("wait", {"generation": generation, "for": "complete"})
picture = os.memfd_create("quilt")  # quiltd writes into it: no file, no --export-dir
words = {"kind": "quilt", "file": "quilt.png", "fds": 1}
job = quiltd.call("export", words, [picture])["job"]
end = quiltd.receive(lambda message: message.get("method") == "export"
                     and message["params"]["job"] == job
                     and message["params"]["state"] not in ("waiting", "running"))
if end["params"]["state"] != "done":
    sys.exit("client.py: the export " + end["params"]["state"])
os.lseek(picture, 0, os.SEEK_SET)
with os.fdopen(picture, "rb") as png, open(sys.argv[2], "wb") as out:
    out.write(png.read())
