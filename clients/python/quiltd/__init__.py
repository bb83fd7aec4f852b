"""A client of quiltd, the daemon that shows light fields on Looking Glass panels.

    import quiltd
    with quiltd.connect() as q:
        q.orbit(yaw=15)
        q.wait("complete", timeout=60)
        open("quilt.png", "wb").write(q.export("quilt"))

quiltd.show(array) puts a volume on the panel, quiltd.show(mesh=(positions, triangles)) a mesh, and
quiltd.show_quilt(array, columns, rows) a quilt.
"""

from typing import Any, Callable, Optional

from .client import Events, Quiltd, connect
from .errors import (
    BadScene,
    Busy,
    Cancelled,
    ConnectionClosed,
    InternalError,
    MethodNotFound,
    NoDaemon,
    NoDevice,
    NotSupported,
    ParameterError,
    PathRefused,
    QuiltdError,
    TimedOut,
)
from .widget import Preview, Widget
from .wire import Event

__version__ = "0.2.0"
__all__ = [
    "BadScene",
    "Busy",
    "Cancelled",
    "ConnectionClosed",
    "Event",
    "Events",
    "InternalError",
    "MethodNotFound",
    "NoDaemon",
    "NoDevice",
    "NotSupported",
    "ParameterError",
    "PathRefused",
    "Preview",
    "Quiltd",
    "QuiltdError",
    "TimedOut",
    "Widget",
    "connect",
    "show",
    "show_quilt",
]


def _connected(show: Callable[[Quiltd], Any]) -> Quiltd:
    client = connect()
    try:
        show(client)
    except BaseException:
        client.close()
        raise
    return client


def show(array: Any = None, spacing: Any = None, scale: Optional[float] = None, *, mesh: Any = None, **keys: Any) -> Quiltd:
    """Connects, and shows an array of (z, y, x) as a volume, or a mesh: see Quiltd.show. Returns the client."""
    return _connected(lambda client: client.show(array, spacing, scale, mesh=mesh, **keys))


def show_quilt(
    array: Any, columns: int, rows: int, aspect: Optional[float] = None, views: Optional[int] = None, name: Optional[str] = None
) -> Quiltd:
    """Connects, and shows an array of (height, width, 3) of uint8 as a quilt: see Quiltd.show_quilt. Returns the client."""
    return _connected(lambda client: client.show_quilt(array, columns, rows, aspect, views, name))
