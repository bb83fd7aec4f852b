#!/usr/bin/env python3
"""A small gateway with the replies that satisfied the real programs, and one that is wrong in a way: the negative control.

    fake.py QUILTCTL SOCKET CALIBRATION IPC ORIGIN [MISTAKE]

It listens on the ports of Bridge and of the older service, and shows pictures through quiltctl at the socket of quiltd.
CALIBRATION: the file of the panel. ORIGIN: pages of this one may call it. Prints a line when it listens, and ends with its input.
MISTAKES says what may be wrong.
"""

import asyncio
import json
import os
import struct
import sys
import tempfile
import zlib

import wire

MISTAKES = {
    "shows nothing": "says Completion and shows nothing",
    "no fringe": "leaves out a number of the calibration",
    "other serial": "tells another panel's calibration",
    "no error": "has no error: 0 in replies of the older service",
    "upside down": "reads BMP from the top",
    "false success": "says Completion for a file that does not exist",
    "any origin": "lets every page in",
    "other identifier": "answers with another request's identifier",
}
TOKEN = "6ba7b810-9dad-11d1-80b4-00c04fd430c8"
NUMBERS = ("DPI center flipImageX flipImageY flipSubp fringe invView pitch screenH screenW slope verticalAngle viewCone").split()


class Fake:
    def __init__(self, quiltctl, quiltd, calibration, ipc, origin, mistake=None):
        self.quiltctl, self.quiltd, self.ipc, self.origin, self.mistake = quiltctl, quiltd, ipc, origin, mistake
        with open(calibration, encoding="utf-8") as file:
            self.calibration = json.load(file)
        if mistake == "other serial":
            self.calibration["serial"] = "LKG-OTHER"
        for name in NUMBERS:
            self.calibration.setdefault(name, {"value": 0})
        if mistake == "no fringe":
            del self.calibration["fringe"]
        self.playlists, self.playing, self.index = {}, None, 0

    def device(self):
        return {"hwid": self.calibration["serial"], "state": "ok", "windowCoords": [1920, 0], "hardwareVersion": "portrait", "index": 0,
                "unityIndex": 1, "joystickIndex": -1, "buttons": [0, 0, 0, 0], "calibration": self.calibration,
                "defaultQuilt": {"quiltX": 3360, "quiltY": 3360, "tileX": 8, "tileY": 6, "quiltAspect": 0.75}}

    async def call(self, method, *arguments):
        if self.mistake == "shows nothing":
            return True
        call = await asyncio.create_subprocess_exec(self.quiltctl, "--socket", self.quiltd, method, *arguments,
                                                    stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.DEVNULL)
        return await call.wait() == 0

    # ---------------------------------------------------------------------------------------- Bridge --

    async def play(self):
        entries = [{"file": entry["uri"], **({"rgbd_in": ("top", "bottom", "right", "left")[int(entry["depth_loc"])]} if int(entry["isRGBD"]) else
                                             {"quilt": f"{entry['cols']}x{entry['rows']}"})} for entry in self.playlists[self.playing]]
        shown = await self.call("playlist.set", "entries:=" + json.dumps(entries)) and await self.call("playlist.play", f"index={self.index}")
        if not shown:
            print(f"fake: {json.dumps(entries)}: cannot be shown", file=sys.stderr, flush=True)
        return shown or self.mistake == "false success"

    async def endpoint(self, name, body):
        """What the payload says and whether all is well."""
        if name in ("bridge_version", "api_version"):
            return "2.6.3", True
        if name == "enter_orchestration":
            return TOKEN, True
        if name == "available_output_devices":
            device = {k: {"value": v} for k, v in self.device().items() if k not in ("unityIndex", "joystickIndex", "buttons")}
            for key in ("calibration", "defaultQuilt"):
                device[key]["value"] = json.dumps(device[key]["value"])
            device["windowCoords"]["value"] = {"x": 1920, "y": 0}
            return {"0": {"value": device}}, True
        if name == "instance_playlist":
            self.playlists[body["name"]] = []
        elif name == "insert_playlist_entry":
            self.playlists[body["name"]].append(body)
        elif name == "play_playlist":
            self.playing, self.index = body["name"], 0
            return {}, await self.play()
        elif name in ("transport_control_next", "transport_control_previous", "transport_control_seek_to_index"):
            last = self.index
            self.index = {"next": self.index + 1, "previous": self.index - 1}.get(name.rpartition("_")[2], body.get("index", 0))
            self.index %= len(self.playlists[self.playing])
            return {}, self.index == last or await self.play()
        elif name in ("transport_control_play", "transport_control_pause"):
            return {}, await self.call("playlist.pause", f"paused={'true' if name.endswith('pause') else 'false'}")
        elif name not in ("show_window", "delete_playlist", "update_current_entry", "exit_orchestration"):
            return {}, False
        return {}, True

    async def http(self, method, path, origin, body):
        if origin and origin != self.origin and self.mistake != "any origin":
            return "403 Forbidden", b""
        if method in ("GET", "OPTIONS"):
            return "200 OK", b""
        if method != "PUT":
            return "405 Method Not Allowed", b""
        payload, well = await self.endpoint(path[1:], json.loads(body))
        return "200 OK", json.dumps({"payload": {"value": payload}, "status": {"value": "Completion" if well else "Failure"}}).encode()

    # ----------------------------------------------------------------------------- the older service --

    async def older(self, message):
        """The reply to a request with its identifier."""
        request = wire.decode(message[4:])
        name, of = next((k, v) for k, v in request["cmd"].items() if isinstance(v, dict))
        reply = {"error": 0, "version": "1.2.0"}
        if name == "info":
            reply["devices"] = [self.device()]
        elif name == "show" and "quilt" in of:
            reply["error"] = 0 if await self.show_bmp(request["bin"], of["quilt"]["settings"]) else 3
        if self.mistake == "no error":
            del reply["error"]
        first = message[:3] + b"\xff" if self.mistake == "other identifier" else message[:4]
        return first + wire.encode(reply)

    async def show_bmp(self, data, settings):
        start, width, height = struct.unpack_from("<I", data, 10)[0], *struct.unpack_from("<ii", data, 18)
        stride = (3 * width + 3) & ~3
        rows = [data[start + y * stride :][: 3 * width] for y in range(height)]
        if self.mistake != "upside down":
            rows.reverse()
        raw = b"".join(b"\0" + bytes(b for x in range(0, len(row), 3) for b in row[x : x + 3][::-1]) for row in rows)
        chunks = [(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)), (b"IDAT", zlib.compress(raw)), (b"IEND", b"")]
        with tempfile.NamedTemporaryFile(suffix=".png") as file:
            file.write(b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(d)) + t + d + struct.pack(">I", zlib.crc32(t + d)) for t, d in chunks))
            file.flush()
            return await self.call("quilt.show", file.name, f"columns={settings['vx']}", f"rows={settings['vy']}", f"aspect={settings['aspect']}")

    async def web_socket(self, reader, writer, path):
        if path == "/":
            writer.write(wire.frame(wire.TEXT, json.dumps(self.calibration).encode(), mask=False))
        while True:
            first, size = await reader.readexactly(2)
            n = size & 127
            if n > 125:
                n = int.from_bytes(await reader.readexactly(2 if n == 126 else 8), "big")
            key = await reader.readexactly(4)
            payload = wire.masked(await reader.readexactly(n), key)
            if first & 15 == wire.CLOSE:
                return
            if path == "/driver" and first & 15 == wire.BINARY:
                writer.write(wire.frame(wire.BINARY, await self.older(payload), mask=False))

    async def on_ipc(self, reader, writer):
        try:
            writer.write(wire.REP)
            await reader.readexactly(8)
            while True:
                await reader.readexactly(1)
                payload = await reader.readexactly(int.from_bytes(await reader.readexactly(8), "big"))
                writer.write(wire.message(await self.older(payload)))
        except (asyncio.IncompleteReadError, ConnectionError):
            writer.close()

    async def on_tcp(self, reader, writer):
        try:
            method, path, _ = (await reader.readline()).decode().split()
            headers = {}
            while line := (await reader.readline()).decode().strip():
                name, _, value = line.partition(":")
                headers[name.lower()] = value.strip()
            origin = headers.get("origin")
            if headers.get("upgrade") and (not origin or origin == self.origin or self.mistake == "any origin"):
                protocol = f"Sec-WebSocket-Protocol: {p}\r\n" if (p := headers.get("sec-websocket-protocol")) else ""
                accept = wire.accept_of(headers["sec-websocket-key"].encode()).decode()
                writer.write(f"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n{protocol}"
                             f"Sec-WebSocket-Accept: {accept}\r\n\r\n".encode())
                await self.web_socket(reader, writer, path)
            else:
                status, body = await self.http(method, path, origin, await reader.readexactly(int(headers.get("content-length", 0))))
                cors = (f"Access-Control-Allow-Origin: {origin}\r\nAccess-Control-Allow-Methods: PUT\r\nAccess-Control-Allow-Headers: content-type\r\n"
                        if origin and not status.startswith("403") else "")
                writer.write(f"HTTP/1.1 {status}\r\n{cors}Content-Length: {len(body)}\r\nConnection: close\r\n\r\n".encode() + body)
        except (asyncio.IncompleteReadError, ConnectionError, ValueError):
            pass
        finally:
            writer.close()

    async def serve(self):
        for port in (33334, 9724, 11222):
            await asyncio.start_server(self.on_tcp, ["127.0.0.1", "::1"] if os.path.exists("/proc/net/if_inet6") else "127.0.0.1", port)
        await asyncio.start_unix_server(self.on_ipc, self.ipc, limit=1 << 26)
        print("listening", flush=True)
        await asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)


if len(sys.argv) not in (6, 7) or (len(sys.argv) == 7 and sys.argv[6] not in MISTAKES):
    sys.exit(__doc__)
asyncio.run(Fake(*sys.argv[1:]).serve())
