"""A client of a running quiltd."""

import contextlib
import mmap
import os
import threading
import time
import weakref
from typing import Any, Dict, Iterable, Iterator, List, Optional, Sequence, Set, Tuple, Union

from . import arrays as memory
from . import panel
from .errors import Cancelled, MethodNotFound, NotSupported, ParameterError, QuiltdError, TimedOut, error_of
from .methods import Group, attributes
from .schema import check, did_you_mean
from .widget import Preview, Widget
from .wire import LONGEST_LINE, Connection, Event, Inbox, encode, sockets

PathOrName = Union[str, "os.PathLike[str]"]
_ENDINGS = {"views": "/", "pictures": "/", "print": ".tif", "chart": ".tif", "state": ".lfstate"}


class Scene(Group):
    """q.scene(document or path) loads; q.scene.load, .get and .patch are the methods of the protocol."""

    def __init__(self, client: "Quiltd", group: Group) -> None:
        super().__init__(group._name)
        self._methods = group._methods
        self._client = client

    def __call__(
        self,
        scene: Union[Dict[str, Any], PathOrName],
        files: Iterable[PathOrName] = (),
        arrays: Optional[Dict[str, Any]] = None,
        **parameters: Any,
    ) -> Dict[str, Any]:
        """Shows a scene document, or a file: a scene, a model, a volume, a quilt or a folder of views.

        files: what the scene names outside of the folders that quiltd may read (`hello` lists them); passed with your rights.
        arrays: the arrays that its volumes and meshes name. Whole numbers in two axes are sent as uint32, others as float32.
        parameters: as of scene.load, for example yaw=30 or quilt="8x6".
        Returns the generation and the warnings. Paths in a document are absolute; its `spacing` is (x, y, z), unlike that of show.
        """
        names = self._paths(files)
        parcels = _parcels(arrays)
        if not isinstance(scene, dict):
            path = self._paths([scene])[0] + ("/" if os.fspath(scene).endswith("/") else "")
            return self._client._load("scene.load", {"file": path, **parameters}, [path, *names], parcels=parcels)
        if not self._client.takes("scene.load", "scene"):
            raise NotSupported("scene: scene.load of this quiltd takes no documents; save it and load it by scene(path)")
        text = encode(scene)
        if len(text) < LONGEST_LINE // 2:
            return self._client._load("scene.load", {"scene": scene, **parameters}, names, parcels=parcels)
        document = memory.sealed([text.encode()])
        try:
            return self._client._load("scene.load", {"scene_fd": True, **parameters}, names, [document], parcels)
        finally:
            os.close(document)

    def patch(
        self, patch: Dict[str, Any], files: Iterable[PathOrName] = (), arrays: Optional[Dict[str, Any]] = None
    ) -> Dict[str, Any]:
        """Changes the scene that is shown: keys with their new values, where None removes a key. files, arrays: as of a scene."""
        return self._client._load("scene.patch", {"patch": patch}, self._paths(files), parcels=_parcels(arrays))

    def _paths(self, names: Iterable[PathOrName]) -> List[str]:
        """Absolute paths. quiltd itself knows which files of its own folders exist."""
        paths = [os.path.abspath(os.fspath(name)) for name in names]
        for path in paths:
            if not self._client._may_read(path) and not os.path.exists(path):
                raise ParameterError(f"scene: {path} does not exist")
        return paths


def _parcels(arrays: Optional[Dict[str, Any]]) -> Dict[str, memory.Parcel]:
    return {name: memory.parcel_by_type(values, name) for name, values in (arrays or {}).items()}


class Events(Iterator[Event]):
    """Notifications, oldest first: for event in q.events("frame"). It ends after `timeout` seconds without one, or by close()."""

    def __init__(self, client: "Quiltd", words: Set[str], timeout: Optional[float]) -> None:
        self.words = words
        self._client, self._timeout = client, timeout
        names = {name for name, about in client.info["events"].items() if about["event"] in words}
        self._inbox: Optional[Inbox] = client._connection.listen(names.__contains__)

    def __next__(self) -> Event:
        inbox = self._inbox
        event = self._client._connection.next_event(inbox, self._timeout) if inbox else None
        if event is None:
            raise StopIteration
        return event

    def close(self) -> None:
        self._inbox = None
        self._client._forget(self)

    def __enter__(self) -> "Events":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()


class Quiltd:
    """A connection to quiltd. Threads may share it; a call that waits in one thread does not hold up another.

    Every method that `hello` lists is an attribute with checked parameters: q.status(), q.camera.orbit(yaw=15),
    q.render.set(denoise="off"). Names that Python reserves get an underscore: q.time.play(from_=1, to=96).
    info: the answer of `hello`.
    """

    scene: Scene

    def __init__(self, socket: Optional[PathOrName] = None) -> None:
        if socket is not None and "://" in os.fspath(socket):
            raise ParameterError(f"connect: {os.fspath(socket)} is a URL; Python needs the path of the socket of quiltd, or nothing")
        self._connection = Connection([os.fspath(socket)] if socket is not None else sockets())
        self._subscribing = threading.Lock()
        self._events: "weakref.WeakSet[Events]" = weakref.WeakSet()  # those that somebody still reads
        try:
            self.info: Dict[str, Any] = self._connection.call("hello", {})
        except BaseException:
            self._connection.close()
            raise
        self._attributes = attributes(self.call, self.info["methods"])
        self.scene = Scene(self, self._attributes.pop("scene"))

    def __getattr__(self, name: str) -> Any:
        found = self.__dict__.get("_attributes", {})
        if name not in found:
            raise MethodNotFound(f"this quiltd has no method {name}{did_you_mean(name, list(found)) or '; it has ' + ', '.join(found)}")
        return found[name]

    def __dir__(self) -> List[str]:
        return sorted({*super().__dir__(), *self._attributes})

    def __enter__(self) -> "Quiltd":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<quiltd {self.info['version']}>"

    def close(self) -> None:
        """Ends the connection; its exports that wait end, too."""
        self._connection.close()

    def takes(self, method: str, parameter: Optional[str] = None) -> bool:
        """Whether this quiltd has a method, and a parameter of it."""
        about = self.info["methods"].get(method)
        return about is not None and (parameter is None or parameter in about["params"].get("properties", {}))

    def call(
        self, method: str, params: Optional[Dict[str, Any]] = None, descriptors: Sequence[int] = (), timeout: Optional[float] = None
    ) -> Any:
        """The result of a method by its name. Wrong parameters raise ParameterError before anything is sent.

        descriptors: open files that come with the call. timeout: seconds to wait for the answer.
        """
        return self._connection.call(method, self.checked(method, params or {}), descriptors, timeout)

    def checked(self, method: str, params: Dict[str, Any]) -> Dict[str, Any]:
        """The parameters of a call as they are sent."""
        about = self.info["methods"].get(method)
        if about is None:
            raise MethodNotFound(f"this quiltd has no method {method}{did_you_mean(method, list(self.info['methods']))}")
        return check(method, params, about["params"])

    def orbit(self, yaw: float = 0, pitch: float = 0, zoom: float = 1) -> Dict[str, Any]:
        """Turns the camera around its target by degrees; zoom=2 halves the distance. Returns the generation."""
        return self.call("camera.orbit", {"yaw": yaw, "pitch": pitch, "zoom": zoom})

    def wait(self, level: str = "coarse", timeout: Optional[float] = None, generation: Optional[int] = None) -> Dict[str, Any]:
        """Returns when the panel shows the newest generation, or this one, at a level: coarse, complete or converged.

        TimedOut after `timeout` seconds.
        """
        params = {"for": level, "timeout": timeout, "generation": generation}
        return self.call("wait", {name: value for name, value in params.items() if value is not None})

    def events(self, *words: str, timeout: Optional[float] = None) -> Events:
        """Notifications of these events from now on; without words: of all.

        The words: frame, converged, scene, device, export, button, playlist, log.
        """
        known = {about["event"] for about in self.info["events"].values()}
        wanted = set(words) or known
        if not wanted <= known:
            raise ParameterError(f"events: {', '.join(sorted(wanted - known))}: quiltd has {', '.join(sorted(known))}")
        events = Events(self, wanted, timeout)
        with self._subscribing:
            self._events.add(events)
            self._subscribe()
        return events

    def export(self, kind: str = "quilt", timeout: Optional[float] = None, **parameters: Any) -> Union[bytes, List[bytes]]:
        """What `quiltctl export` writes, as bytes; a list for views and pictures, and for print and chart (TIFF, manifest).

        parameters: as of the method export, for example wait="complete" or denoise="off"; file="a.exr" chooses the format.
        TimedOut after `timeout` seconds; the export then ends.
        """
        end = None if timeout is None else time.monotonic() + timeout
        count = {"views": self._views, "pictures": self._views, "print": lambda: 2, "chart": lambda: 2}.get(kind, lambda: 1)()
        files = memory.empty_files(count)
        try:
            inbox = self._connection.listen("export".__eq__)
            params = {"kind": kind, "file": kind + _ENDINGS.get(kind, ".png"), **parameters, "fds": count}
            self._finish(self.call("export", params, files, timeout)["job"], inbox, end)
            results = [memory.contents(file) for file in files]
        finally:
            memory.close_all(files)
        return results[0] if kind not in ("views", "pictures", "print", "chart") else results

    def preview(self, width: Optional[int] = 210, views: Optional[int] = None, quality: Optional[int] = None) -> Preview:
        """The image that is shown now as the bytes of a JPEG quilt, with `info` about its tiles.

        width: of a view in pixels, at most as rendered; None: as rendered. views: how many, evenly spaced; None: all.
        """
        with self._frame({"format": "jpeg", "width": width, "views": views, "quality": quality}) as (file, info):
            return Preview(memory.contents(file), info)

    def array(self, width: Optional[int] = None, views: Optional[int] = None) -> memoryview:
        """The image that is shown now, as a quilt of (height, width, 3) bytes: sRGB, rows from the top, view 0 at the bottom left.

        numpy.asarray(q.array(views=1)) is the middle view as an array, without a copy. width, views: as of preview, whose
        `info` has the tiles; None: as rendered, and all.
        """
        with self._frame({"format": "raw", "width": width, "views": views}) as (file, info):
            shape = [info["rows"] * info["height"], info["columns"] * info["width"], 3]
            return memoryview(mmap.mmap(file, 0)).cast("B", shape)

    def widget(self, width: int = 420, views: Optional[int] = None, quality: Optional[int] = None) -> Widget:
        """For Jupyter: the image that is shown now. The pointer, a finger or the arrow keys turn it through its views."""
        return Widget(self.preview(width, views, quality), width)

    def show(
        self, array: Any = None, spacing: Any = None, scale: Optional[float] = None, *, mesh: Any = None, **keys: Any
    ) -> Dict[str, Any]:
        """Shows an array of (z, y, x) as a volume, or a mesh, in daylight.

        A volume has values that are not negative; float32 is sent as it is, and masked values as 0.
        spacing: size of a voxel, a number (1) or (z, y, x); a scene document has (x, y, z).
        scale: extinction per unit of length = scale times the value; None: the densest voxels make the volume opaque.
        keys: more keys of a scene's volume, such as albedo=[1, 0.6, 0.4]; emission may be an array of the same shape, or an
        object with one: emission={"array": heat, "scale": 20, "colour": [1, 0.5, 0.2]}.

        mesh=(positions, triangles): positions of shape (n, 3), and for each triangle three of their rows; then, if there are
        any, normals (n, 3) and uvs (n, 2). keys: more keys of a scene's mesh; material may be an object: {"albedo": [1, 0, 0]}.
        """
        if (array is None) == (mesh is None):
            raise ParameterError("show: expected an array of (z, y, x), or mesh=(positions, triangles)")
        if mesh is None:
            return panel.show_volume(self, array, 1.0 if spacing is None else spacing, scale, keys)
        for name, value in (("spacing", spacing), ("scale", scale)):
            if value is not None:
                raise ParameterError(f"show: {name} is for volumes; scale the positions of a mesh instead")
        return panel.show_mesh(self, mesh, keys)

    def show_quilt(
        self, array: Any, columns: int, rows: int, aspect: Optional[float] = None, views: Optional[int] = None, name: Optional[str] = None
    ) -> Dict[str, Any]:
        """Shows an array of (height, width, 3) of uint8 as a quilt, rows from the top; view 0 is at the bottom left.

        aspect: width / height of a view. views: how many of the tiles are views; None: all. name: in messages.
        """
        return panel.show_quilt(self, array, columns, rows, {"aspect": aspect, "views": views, "name": name})

    @contextlib.contextmanager
    def _frame(self, params: Dict[str, Any]) -> Iterator[Tuple[int, Dict[str, Any]]]:
        """A file with the result of frame.get, and its answer."""
        if not self.takes("frame.get"):
            raise NotSupported('this quiltd has no method frame.get; export("quilt", file="quilt.jpg") gives a whole quilt')
        if params["width"] is not None:
            params["width"] = min(params["width"], self.call("status").get("view_width", params["width"]))
        (file,) = memory.empty_files(1)
        try:
            yield file, self.call("frame.get", {name: value for name, value in params.items() if value is not None}, [file])
        finally:
            os.close(file)

    def _views(self) -> int:
        return self.call("status").get("views", 1)

    def _finish(self, job: int, inbox: Inbox, end: Optional[float]) -> None:
        """Waits for the end of an export. If it is not waited for any more, it ends, too."""
        state, params = "running", {}
        try:
            while state in ("waiting", "running"):
                event = self._connection.next_event(inbox, None if end is None else max(end - time.monotonic(), 0.0))
                if event is None:
                    raise TimedOut(f"export: not done in time (job {job})")
                if event["job"] == job:
                    state, params = event["state"], event.params
        except BaseException as error:
            if not isinstance(error, ConnectionError):
                self._cancel(job)
            raise
        if state == "cancelled":
            raise Cancelled(f"export: job {job} was cancelled")
        if state != "done":
            raise error_of(params.get("error", {"message": f"export: {state}"}))

    def _cancel(self, job: int) -> None:
        try:
            self.call("job.cancel", {"job": job})
        except QuiltdError:  # it ended meanwhile
            pass

    def _load(
        self,
        method: str,
        params: Dict[str, Any],
        names: Sequence[str] = (),
        documents: Sequence[int] = (),
        parcels: Optional[Dict[str, memory.Parcel]] = None,
    ) -> Dict[str, Any]:
        """scene.load or scene.patch with arrays; of these files it passes those that quiltd may not open itself."""
        passed: Dict[str, int] = {}
        sent: List[int] = []
        try:
            for name in names:
                if name not in passed and os.path.isfile(name) and not self._may_read(name):
                    passed[name] = os.open(name, os.O_RDONLY | os.O_CLOEXEC)
            if passed:
                params = {**params, "files": list(passed)}
            if parcels:
                params = {**params, "arrays": {name: {"shape": list(p.shape), "type": p.kind} for name, p in parcels.items()}}
            for parcel in (parcels or {}).values():
                sent.append(parcel.sealed())
            return self.call(method, params, [*documents, *passed.values(), *sent])
        finally:
            memory.close_all([*passed.values(), *sent])

    def _may_read(self, name: str) -> bool:
        return any(name.startswith(folder.rstrip("/") + "/") for folder in self.info["folders"])

    def _forget(self, events: Events) -> None:
        with self._subscribing:
            if events in self._events:
                self._events.discard(events)
                self._subscribe()

    def _subscribe(self) -> None:
        self.call("subscribe", {"events": sorted({word for events in self._events for word in events.words})})


def connect(socket: Optional[PathOrName] = None) -> Quiltd:
    """A client of the quiltd at this socket; without one, of $QUILTD_SOCKET, $XDG_RUNTIME_DIR/quiltd.sock or the service."""
    return Quiltd(socket)
