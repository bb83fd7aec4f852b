"""What can fail. Every error is a QuiltdError; quiltd's own carry the code and the data of its answer."""

from typing import Any, Dict, Optional, Type


class QuiltdError(Exception):
    """code: of JSON-RPC, None if the client found the mistake. data: may have file, line and pointer."""

    code: Optional[int] = None

    def __init__(self, message: str, code: Optional[int] = None, data: Optional[Dict[str, Any]] = None) -> None:
        super().__init__(message)
        if code is not None:
            self.code = code
        self.data: Dict[str, Any] = data or {}


class NoDaemon(QuiltdError, ConnectionError):
    """No quiltd answers on any of the sockets."""


class ConnectionClosed(QuiltdError, ConnectionError):
    """quiltd ended, or closed this connection."""


class NotSupported(QuiltdError):
    """This quiltd lacks a method or a parameter that the call needs."""


class Cancelled(QuiltdError):
    """Somebody ended the export."""


class MethodNotFound(QuiltdError, AttributeError):
    code = -32601


class ParameterError(QuiltdError, ValueError):
    """A parameter is unknown, missing, of the wrong type or out of range. Nothing has changed."""

    code = -32602


class InternalError(QuiltdError):
    code = -32603


class Busy(QuiltdError):
    """A limit is reached, or the call is not possible now."""

    code = -32000


class PathRefused(QuiltdError, PermissionError):
    """quiltd may not read or write this path."""

    code = -32001


class BadScene(QuiltdError):
    """The scene, or a file of it, is wrong. The old image stays."""

    code = -32002


class NoDevice(QuiltdError):
    code = -32003


class TimedOut(QuiltdError, TimeoutError):
    code = -32004


_CLASSES: Dict[Optional[int], Type[QuiltdError]] = {
    kind.code: kind
    for kind in (MethodNotFound, ParameterError, InternalError, Busy, PathRefused, BadScene, NoDevice, TimedOut)
}


def error_of(answer: Dict[str, Any]) -> QuiltdError:
    """The exception for the error object of an answer."""
    code = answer.get("code")
    return _CLASSES.get(code, QuiltdError)(answer.get("message", "unknown error"), code, answer.get("data"))
