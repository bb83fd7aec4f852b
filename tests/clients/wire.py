"""The bytes of the older services: CBOR (RFC 8949) of maps, arrays, texts, bytes and numbers, WebSocket frames (RFC 6455), and
messages of nng over a Unix socket. For program.py and fake.py."""

import base64
import hashlib
import os
import struct

GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
TEXT, BINARY, CLOSE = 1, 2, 8
REQ, REP = bytes.fromhex("0053500000300000"), bytes.fromhex("0053500000310000")


def head(kind, n):
    if n < 24:
        return bytes([kind << 5 | n])
    for code, size in ((24, 1), (25, 2), (26, 4), (27, 8)):
        if n < 1 << 8 * size:
            return bytes([kind << 5 | code]) + n.to_bytes(size, "big")
    raise ValueError("a number of more than 64 bits")


def encode(value):
    if value is None or isinstance(value, bool):
        return {None: b"\xf6", False: b"\xf4", True: b"\xf5"}[value]
    if isinstance(value, int):
        return head(0, value) if value >= 0 else head(1, -1 - value)
    if isinstance(value, float):
        return b"\xfb" + struct.pack(">d", value)
    if isinstance(value, bytes):
        return head(2, len(value)) + value
    if isinstance(value, str):
        return head(3, len(value.encode())) + value.encode()
    if isinstance(value, list):
        return head(4, len(value)) + b"".join(map(encode, value))
    return head(5, len(value)) + b"".join(encode(k) + encode(v) for k, v in value.items())


def decode(data):
    """The value of all of `data`."""
    value, rest = decode_first(data)
    if rest:
        raise ValueError(f"{len(rest)} bytes follow the CBOR value")
    return value


def decode_first(data):
    kind, code, data = data[0] >> 5, data[0] & 31, data[1:]
    if kind == 7 and code in (20, 21, 22):
        return {20: False, 21: True, 22: None}[code], data
    size = 0 if code < 24 else {24: 1, 25: 2, 26: 4, 27: 8}[code]
    number, data = data[:size], data[size:]
    if kind == 7:
        return struct.unpack({2: ">e", 4: ">f", 8: ">d"}[size], number)[0], data
    n = int.from_bytes(number, "big") if size else code
    if kind < 2:
        return (n if kind == 0 else -1 - n), data
    if kind < 4:
        if len(data) < n:
            raise ValueError("the CBOR text or bytes end early")
        return (data[:n] if kind == 2 else data[:n].decode()), data[n:]
    if kind == 6:
        raise ValueError("a CBOR tag")
    values = []
    for _ in range(n * (kind - 3)):
        value, data = decode_first(data)
        values.append(value)
    return (values if kind == 4 else dict(zip(values[::2], values[1::2]))), data


def accept_of(key):
    return base64.b64encode(hashlib.sha1(key + GUID).digest())


def frame(opcode, payload, mask):
    """A whole message. mask: as clients send it."""
    n = len(payload)
    size = bytes([n]) if n < 126 else b"\x7e" + struct.pack(">H", n) if n < 65536 else b"\x7f" + struct.pack(">Q", n)
    if not mask:
        return bytes([0x80 | opcode]) + size + payload
    key = os.urandom(4)
    return bytes([0x80 | opcode, size[0] | 0x80]) + size[1:] + key + masked(payload, key)


def masked(payload, key):
    n = len(payload)
    return (int.from_bytes(payload, "big") ^ int.from_bytes((key * (n // 4 + 1))[:n], "big")).to_bytes(n, "big")


def message(payload):
    """As nng sends it over a Unix socket."""
    return b"\x01" + struct.pack(">Q", len(payload)) + payload
