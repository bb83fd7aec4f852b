#!/usr/bin/env python3
"""Says what programs for Looking Glass panels say, request by request, without any package.

    program.py alice SOCKET            AliceLG: init, info, a picture of QUILT (stdin), without reading the reply to it
    program.py demo SOCKET             AliceLG: show without a picture, hide and wipe
    program.py vtk SOCKET              the library of VTK's module: init and info
    program.py nngcat URL              what nng's own client gets for info
    program.py bindata SOCKET|ws       as alice, but reads the reply to show
    program.py text                    what ws://localhost:11222/ says first
    program.py quiltwright FILE        quiltwright --cast
    program.py pause | resume          its functions pause_quilt and resume_quilt, which enter an orchestration each
    program.py newest FILE…            bridge.js as in its repository: a playlist of quilts of 4 columns and 2 rows
    program.py ask ENDPOINT BODY       one request of Bridge

SOCKET: the path of nng's Unix socket, or ws for ws://127.0.0.1:11222/driver. Prints one JSON value: what the program learnt.
Exit status 1, with the reason, if the program could not go on.
"""

import json
import os
import random
import socket
import subprocess
import sys
import urllib.error
import urllib.request

import wire

PATIENCE = 60  # seconds


class Stopped(Exception):
    pass


class Stream:
    """A socket that is read by so many bytes."""

    def __init__(self, plug):
        plug.settimeout(PATIENCE)
        self.plug = plug

    def read(self, n):
        data = b""
        while len(data) < n:
            more = self.plug.recv(n - len(data))
            if not more:
                raise Stopped(f"the connection ended after {len(data)} of {n} bytes")
            data += more
        return data

    def line(self):
        data = b""
        while not data.endswith(b"\r\n"):
            data += self.read(1)
        return data[:-2]


# --------------------------------------------------------------------------- transports of the older service --


class Ipc:
    """nng's REQ over a Unix socket."""

    def __init__(self, path):
        plug = socket.socket(socket.AF_UNIX)
        plug.settimeout(PATIENCE)
        plug.connect(path)
        self.stream = Stream(plug)
        plug.sendall(wire.REQ)
        greeting = self.stream.read(8)
        if greeting != wire.REP:
            raise Stopped(f"the greeting is {greeting.hex()}, expected {wire.REP.hex()}")

    def send(self, payload):
        self.stream.plug.sendall(wire.message(payload))

    def receive(self):
        kind = self.stream.read(1)
        if kind != b"\x01":
            raise Stopped(f"a message begins with {kind.hex()}, expected 01")
        return self.stream.read(int.from_bytes(self.stream.read(8), "big"))


class WebSocket:
    """A client of port 11222 or 9724, as browsers and nng are."""

    def __init__(self, port, path, protocol=None):
        self.stream = Stream(socket.create_connection(("127.0.0.1", port), PATIENCE))
        lines = [f"GET {path} HTTP/1.1", f"Host: localhost:{port}", "Connection: Upgrade", "Upgrade: websocket",
                 "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
                 "Sec-WebSocket-Extensions: permessage-deflate; client_max_window_bits"]
        if protocol:
            lines.append(f"Sec-WebSocket-Protocol: {protocol}")
        self.stream.plug.sendall("\r\n".join([*lines, "", ""]).encode())
        status = self.stream.line().decode()
        if " 101 " not in status:
            raise Stopped(f"the WebSocket was refused: {status}")
        headers = {}
        while line := self.stream.line().decode():
            name, _, value = line.partition(":")
            headers[name.lower()] = value.strip()
        if protocol and headers.get("sec-websocket-protocol") != protocol:
            raise Stopped(f"the protocol {protocol} was not accepted")
        if "sec-websocket-extensions" in headers:
            raise Stopped("an extension was accepted")

    def send(self, payload):
        self.stream.plug.sendall(wire.frame(wire.BINARY, payload, mask=True))

    def say(self, text):
        self.stream.plug.sendall(wire.frame(wire.TEXT, text.encode(), mask=True))

    def receive(self):
        parts = b""
        while True:
            first, size = self.stream.read(2)
            n = size & 127
            if n > 125:
                n = int.from_bytes(self.stream.read(2 if n == 126 else 8), "big")
            part = self.stream.read(n)
            if first & 15 == wire.CLOSE:
                raise Stopped(f"the WebSocket was closed: {part[2:].decode()}")
            if first & 15 < wire.CLOSE:
                parts += part
            if first & 0x80 and first & 15 < wire.CLOSE:
                return parts


class Service:
    """Requests of the older service and their replies, whose identifiers must be those of the requests."""

    def __init__(self, where):
        self.socket = WebSocket(11222, "/driver", "rep.sp.nanomsg.org") if where == "ws" else Ipc(where)
        self.id = random.getrandbits(31) | 1 << 31

    def send(self, request):
        self.id = (self.id + 1) | 1 << 31
        self.socket.send(self.id.to_bytes(4, "big") + wire.encode(request))

    def call(self, request):
        self.send(request)
        while True:  # replies to requests that were given up are left out
            reply = self.socket.receive()
            if int.from_bytes(reply[:4], "big") == self.id:
                return wire.decode(reply[4:])


def bmp(width, height, top_down):
    """24 bits, bottom-up, as AliceLG sends it."""
    stride = (3 * width + 3) & ~3
    rows = [top_down[3 * width * y : 3 * width * (y + 1)] for y in reversed(range(height))]
    body = b"".join(bytes(b for x in range(0, len(row), 3) for b in row[x : x + 3][::-1]).ljust(stride, b"\0") for row in rows)
    size = 54 + len(body)
    numbers = [(size, 4), (0, 4), (54, 4), (40, 4), (width, 4), (height, 4), (1, 2), (24, 2), (0, 4), (len(body), 4), (2835, 4), (2835, 4)]
    return b"BM" + b"".join(n.to_bytes(bytes_, "little") for n, bytes_ in numbers + [(0, 4), (0, 4)]) + body


def initialised(where, app):
    service = Service(where)
    reply = service.call({"cmd": {"init": {"appid": app}}, "bin": ""})
    if reply.get("error") != 0 or not reply.get("version"):
        raise Stopped(f"init: {reply}")
    reply = service.call({"cmd": {"info": {}}, "bin": ""})
    if reply.get("error") != 0:
        raise Stopped(f"info: {reply}")
    devices = [d for d in reply["devices"] if d["state"] == "ok"]
    if not devices:
        raise Stopped("info: no device has the state ok")
    return service, devices[0]


def show_of(picture):
    settings = {"vx": picture["columns"], "vy": picture["rows"], "vtotal": picture["columns"] * picture["rows"],
                "aspect": picture["aspect"], "invert": False}
    data = bmp(picture["width"], picture["height"], bytes.fromhex(picture["pixels"]))
    return {"cmd": {"show": {"targetDisplay": 0, "source": "bindata", "quilt": {"type": "image", "settings": settings}}}, "bin": data}


def alice(where):
    service, device = initialised(where, "Alice/LG")
    service.send(show_of(json.load(sys.stdin)))
    # the reply to show is never read; the next request comes with it still on its way
    reply = service.call({"cmd": {"info": {}}, "bin": ""})
    return {"device": device, "after": reply.get("error")}


def demo(where):
    service, _ = initialised(where, "Alice/LG")
    # the target of wipe is beside it
    commands = {"show": {"targetDisplay": 0}}, {"hide": {"targetDisplay": 0}}, {"targetDisplay": 0, "wipe": {}}
    return [service.call({"cmd": command, **({} if "show" in command else {"bin": b""})}) for command in commands]


def vtk(where):
    _, device = initialised(where, "ParaView")
    found = {name: device["calibration"][name]["value"] for name in
             ("pitch", "slope", "center", "viewCone", "invView", "DPI", "screenW", "screenH", "flipImageX", "flipImageY", "flipSubp")}
    return {"device": device, "numbers": found}


def bindata(where):
    service, _ = initialised(where, "quiltd-test")
    return service.call(show_of(json.load(sys.stdin)))


def nngcat(url):
    asked = wire.encode({"cmd": {"info": {}}, "bin": ""})
    told = subprocess.run(["nngcat", "--req", "--dial", url, "--hex", "--recv-timeout", str(PATIENCE), "--file", "/dev/stdin"],
                          input=asked, capture_output=True, check=False)
    if told.returncode != 0 or not told.stdout:
        raise Stopped(told.stderr.decode().strip() or "nngcat got no reply")
    text = told.stdout.decode().strip().strip('"')
    return wire.decode(bytes.fromhex("".join(text.split("\\x"))))


def text():
    return json.loads(WebSocket(11222, "/").receive())


# ------------------------------------------------------------------------------------------------- Bridge --


def put(endpoint, body, kind="application/json"):
    request = urllib.request.Request(f"http://localhost:33334/{endpoint}", data=json.dumps(body).encode(),
                                     headers={"Content-Type": kind}, method="PUT")
    try:
        with urllib.request.urlopen(request, timeout=PATIENCE) as reply:
            return json.loads(reply.read())
    except urllib.error.HTTPError as error:
        raise Stopped(f"{endpoint}: {error}: {error.read().decode()}") from error


def done(endpoint, body):
    reply = put(endpoint, body)
    if reply["status"]["value"] not in ("Completion", "Pending"):
        raise Stopped(f"{endpoint}: {json.dumps(reply)}")
    return reply


def enter():
    return done("enter_orchestration", {"name": "default"})["payload"]["value"]


def quiltwright(path):
    token = enter()
    done("show_window", {"orchestration": token, "show_window": True, "head_index": -1})
    done("instance_playlist", {"orchestration": token, "name": "quiltwright", "loop": True})
    done("insert_playlist_entry", {"orchestration": token, "name": "quiltwright", "index": 0, "uri": os.path.abspath(path), "rows": 2,
                                   "cols": 4, "aspect": 0.75, "view_count": 8, "durationMS": 20000, "isRGBD": 0})
    return done("play_playlist", {"orchestration": token, "name": "quiltwright", "head_index": -1})


def pause():
    return done("transport_control_pause", {"orchestration": enter()})


def resume():
    return done("transport_control_play", {"orchestration": enter()})


def newest(*paths):
    token = enter()
    events = WebSocket(9724, "/event_source")
    events.say(json.dumps({"subscribe_orchestration_events": token}))
    name = f"Cast_{random.getrandbits(32):x}"
    done("instance_playlist", {"orchestration": token, "name": name, "loop": True})
    for i, path in enumerate(paths):
        done("insert_playlist_entry", {"orchestration": token, "id": i, "name": name, "index": i, "uri": path, "rows": 2, "cols": 4,
                                       "durationMS": 86400000, "focus": 0, "zoom": 1, "crop_pos_x": 0, "crop_pos_y": 0,
                                       "aspect": 0.75, "view_count": 8, "isRGBD": 0, "tag": ""})
    done("play_playlist", {"orchestration": token, "name": name, "head_index": -1})
    for parameter, value in (("focus", "0.02"), ("zoom", "1.5"), ("crop_pos_x", "0.1"), ("focus", "0"), ("zoom", "1"), ("crop_pos_x", "0")):
        done("update_current_entry", {"orchestration": token, "name": name, parameter: value})
    return {"orchestration": token, "name": name}


def ask(endpoint, body):
    return put(endpoint, json.loads(body), "text/plain")  # as programs in C# say


def main():
    program = {f.__name__: f for f in (alice, demo, vtk, nngcat, bindata, text, quiltwright, pause, resume, newest, ask)}.get(sys.argv[1] if sys.argv[1:] else "")
    if not program:
        print(__doc__)
        return 2
    try:
        print(json.dumps(program(*sys.argv[2:])))
    except (Stopped, OSError, ValueError, KeyError, TypeError) as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return 1
    return 0


sys.exit(main())
