"""A daemon of a thread, for methods and faults that a real one does not show: it answers by a table of functions."""

import array
import json
import os
import shutil
import socket
import tempfile
import threading
import unittest

import quiltd

NUMBER = {"type": "number"}
TEXT = {"type": "string"}
COUNT = {"type": "integer", "minimum": 1}
METHODS = {
    "hello": {},
    "status": {},
    "subscribe": {"events": {"type": "array", "items": TEXT}},
    "camera.orbit": {"yaw": NUMBER, "pitch": NUMBER, "zoom": NUMBER},
    "scene.load": {
        "file": TEXT,
        "files": {"type": "array", "items": TEXT},
        "name": TEXT,
        "scene": {"type": "object"},
        "scene_fd": {"type": "boolean"},
        "arrays": {"type": "object"},
    },
    "scene.patch": {"patch": {"type": "object"}, "files": {"type": "array", "items": TEXT}, "arrays": {"type": "object"}},
    "frame.get": {"format": TEXT, "width": COUNT, "views": COUNT, "quality": COUNT},
    "quilt.show": {"columns": COUNT, "rows": COUNT, "aspect": NUMBER, "width": COUNT, "height": COUNT, "views": COUNT, "name": TEXT},
    "export": {"kind": TEXT, "file": TEXT, "wait": TEXT, "fds": {"type": "integer"}},
    "job.cancel": {"job": {"type": "integer"}},
}
EVENTS = {name: {"event": name, "params": {}} for name in ("frame", "export", "scene")}


class Refused(Exception):
    """An error object as the answer."""


class Fake:
    """calls: (method, params) as they came. answers: per method, what to return for (params, files of the call)."""

    def __init__(self, without=()):
        self.calls, self.answers = [], {}
        self.hello = {
            "version": "0.0.0",
            "folders": ["/dev/null"],
            "events": EVENTS,
            "methods": {
                name: {"summary": name, "params": {"type": "object", "additionalProperties": False, "properties": properties}}
                for name, properties in METHODS.items()
                if name not in without
            },
        }
        self.folder = tempfile.mkdtemp()
        self.path = os.path.join(self.folder, "s")
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(self.path)
        self.listener.listen()
        self.connections = []
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self):
        for connection in [self.listener, *self.connections]:
            try:
                connection.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            connection.close()
        shutil.rmtree(self.folder)

    def notify(self, name, **params):
        self.send({"jsonrpc": "2.0", "method": name, "params": params})

    def send(self, message):
        self.connections[-1].sendall(json.dumps(message).encode() + b"\n")

    def _accept(self):
        try:
            while True:
                connection, _ = self.listener.accept()
                self.connections.append(connection)
                threading.Thread(target=self._serve, args=(connection,), daemon=True).start()
        except OSError:
            pass

    def _serve(self, connection):
        received, files = b"", []
        try:
            while True:
                data, rights, _, _ = connection.recvmsg(1 << 16, socket.CMSG_SPACE(253 * 4))
                if not data:
                    return
                for _, _, words in rights:
                    files += array.array("i", words[: len(words) // 4 * 4])
                received += data
                *lines, received = received.split(b"\n")
                for line in lines:
                    self._answer(json.loads(line), files)
                    while files:
                        os.close(files.pop())
        except OSError:
            pass

    def _answer(self, call, files):
        method, params = call["method"], call["params"]
        self.calls.append((method, params))
        answer = self.answers.get(method, lambda params, files: self.hello if method == "hello" else {})
        message = {"jsonrpc": "2.0", "id": call["id"]}
        try:
            result = answer(params, files)
            if result is None:  # no answer
                return
            message["result"] = result
        except Refused as refused:
            message["error"] = refused.args[0]
        self.send(message)


class FakeCase(unittest.TestCase):
    """fake, and a client q of it."""

    without = ()

    def setUp(self):
        self.fake = Fake(self.without)
        self.addCleanup(self.fake.close)
        self.q = quiltd.connect(self.fake.path)
        self.addCleanup(self.q.close)

    def sent(self, method):
        """Parameters of the calls of a method."""
        return [params for name, params in self.fake.calls if name == method]


def floats(shape, values):
    """A float32 array as numpy would export it."""
    return memoryview(array.array("f", values)).cast("B").cast("f", shape)


def whole(shape, values, code="q"):
    """The same of whole numbers."""
    return memoryview(array.array(code, values)).cast("B").cast(code, shape)
