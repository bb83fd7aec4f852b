"""The connection: one JSON object per line over a Unix socket, with descriptors.

Threads may share it. Whoever waits for an answer or an event reads the socket for all that wait.
"""

import array
import collections
import json
import os
import select
import socket
import threading
import time
import weakref
from typing import Any, Callable, Deque, Dict, Iterable, List, NamedTuple, Optional, Sequence

from .errors import ConnectionClosed, NoDaemon, ParameterError, TimedOut, error_of

LONGEST_LINE = 1 << 20
KEPT_EVENTS = 1024


class Event(NamedTuple):
    """A notification: its name, and its params as a dict. event["generation"] is short for event.params["generation"]."""

    name: str
    params: Dict[str, Any]

    def __getitem__(self, key: Any) -> Any:
        return self.params[key] if isinstance(key, str) else tuple.__getitem__(self, key)


class Inbox:
    """Notifications that one reader wants, oldest first. It keeps the newest KEPT_EVENTS of those that were not read."""

    def __init__(self, wanted: Callable[[str], bool]) -> None:
        self.wanted = wanted
        self.events: Deque[Event] = collections.deque(maxlen=KEPT_EVENTS)


def sockets() -> List[str]:
    """Where a daemon may listen, in the order of quiltctl."""
    named, runtime = os.environ.get("QUILTD_SOCKET"), os.environ.get("XDG_RUNTIME_DIR", "")
    found = [named] if named else []
    if runtime.startswith("/"):
        found.append(runtime + "/quiltd.sock")
    return [*found, "/run/quiltd/control.sock"]


def open_socket(paths: Sequence[str]) -> socket.socket:
    """A socket that is connected to the first of these paths on which somebody answers."""
    reasons = []
    for path in paths:
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            connection.connect(path)
            return connection
        except OSError as error:
            connection.close()
            reasons.append(f"{path}: {error.strerror or error}")
    raise NoDaemon(f"no quiltd answers ({'; '.join(reasons)}); start one: quiltd SCENE")


def plain(value: Any) -> Any:
    """For json.dumps: numbers and arrays of numpy, and paths."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} is no JSON")


def encode(value: Any) -> str:
    """JSON as quiltd reads it: without NaN."""
    try:
        return json.dumps(value, default=plain, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"not JSON: {error}") from None


class Connection:
    def __init__(self, paths: Sequence[str]) -> None:
        self._socket = open_socket(paths)
        self._sending = threading.Lock()
        self._changed = threading.Condition()  # guards all below
        self._reading = False
        self._received = bytearray()
        self._answers: Dict[int, Optional[Dict[str, Any]]] = {}
        self._inboxes: "weakref.WeakSet[Inbox]" = weakref.WeakSet()
        self._last = 0
        self._closed: Optional[str] = None

    def call(self, method: str, params: Dict[str, Any], descriptors: Iterable[int] = (), timeout: Optional[float] = None) -> Any:
        """The result of one call. The daemon gets copies of the descriptors."""
        with self._changed:
            self._last += 1
            number = self._last
            self._answers[number] = None
        try:
            self._send({"jsonrpc": "2.0", "id": number, "method": method, "params": params}, list(descriptors))
            if not self.until(lambda: self._answers[number] is not None, timeout):
                raise TimedOut(f"{method}: no answer within {timeout:g} s")
            answer = self._answers[number] or {}
        finally:
            with self._changed:
                del self._answers[number]
        if "error" in answer:
            raise error_of(answer["error"])
        return answer["result"]

    def listen(self, wanted: Callable[[str], bool]) -> Inbox:
        """Notifications whose name is wanted go to this inbox, as long as somebody holds it."""
        inbox = Inbox(wanted)
        with self._changed:
            self._inboxes.add(inbox)
        return inbox

    def next_event(self, inbox: Inbox, timeout: Optional[float] = None) -> Optional[Event]:
        """The oldest event of an inbox. None: there was none within timeout seconds."""
        if not self.until(lambda: bool(inbox.events), timeout):
            return None
        return inbox.events.popleft()

    def until(self, done: Callable[[], bool], timeout: Optional[float]) -> bool:
        """Reads until done() holds. False: the time has passed."""
        end = None if timeout is None else time.monotonic() + timeout
        with self._changed:
            while not done():
                left = None if end is None else end - time.monotonic()
                if self._closed is not None:
                    raise ConnectionClosed(self._closed)
                if left is not None and left <= 0:
                    return False
                if self._reading:
                    self._changed.wait(left)
                else:
                    self._read(left)
            return True

    def close(self) -> None:
        with self._changed:
            self._closed = self._closed or "the connection is closed"
            self._changed.notify_all()
        try:
            self._socket.shutdown(socket.SHUT_RDWR)  # wakes a thread that reads
        except OSError:
            pass
        self._socket.close()

    def _read(self, timeout: Optional[float]) -> None:
        """Reads once, without the lock that the caller holds."""
        self._reading = True
        self._changed.release()
        received: Optional[bytes] = b""
        try:
            received = self._receive(timeout)
        finally:
            self._changed.acquire()
            self._reading = False
            self._changed.notify_all()
        if received is None:
            return
        if not received:
            self._closed = self._closed or "quiltd closed the connection"
        self._received += received
        *lines, rest = self._received.split(b"\n")
        self._received = bytearray(rest)
        for line in lines:
            self._take(json.loads(line))

    def _receive(self, timeout: Optional[float]) -> Optional[bytes]:
        """Bytes; none at the end of the connection. None: the time has passed."""
        try:
            poll = select.poll()
            poll.register(self._socket, select.POLLIN)
            if not poll.poll(None if timeout is None else timeout * 1000):
                return None
            return self._socket.recv(1 << 16)
        except (OSError, ValueError):  # another thread has closed it
            return b""

    def _take(self, message: Dict[str, Any]) -> None:
        if "method" in message:
            event = Event(message["method"], message.get("params", {}))
            for inbox in self._inboxes:
                if inbox.wanted(event.name):
                    inbox.events.append(event)
        elif message.get("id") in self._answers:
            self._answers[message["id"]] = message
        elif message.get("id") is None and "error" in message:  # why quiltd closes the connection next
            self._closed = message["error"].get("message")

    def _send(self, message: Dict[str, Any], descriptors: List[int]) -> None:
        line = encode(message).encode() + b"\n"
        if len(line) > LONGEST_LINE:
            raise ParameterError(f"{message['method']}: the call has {len(line)} bytes, at most {LONGEST_LINE}")
        rights = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", descriptors))]
        with self._sending:
            try:
                sent = self._socket.sendmsg([line], rights if descriptors else [])
                if sent < len(line):
                    self._socket.sendall(line[sent:])
            except (BrokenPipeError, ConnectionResetError):
                pass  # quiltd has ended: its last words, and its end, are read next
            except OSError as error:
                if self._closed is None:  # a descriptor that is not open
                    raise ParameterError(f"{message['method']}: {error.strerror}") from None
                raise ConnectionClosed(self._closed) from None
            except BaseException:  # half a line is sent: nothing can follow it
                self.close()
                raise
