"""Arrays on the panel."""

import math
from typing import TYPE_CHECKING, Any, Dict, Optional, Sequence, Tuple

from . import arrays
from .errors import NotSupported, ParameterError
from .schema import did_you_mean

if TYPE_CHECKING:
    from .client import Quiltd

OPTICAL_DEPTH = 8.0  # of a volume full of its densest value, seen through its mean side
MESH_ARRAYS = ("positions", "triangles", "normals", "uvs")
MATRIX = 16  # values: the largest array that a key of a scene has


def daylight(**objects: Any) -> Dict[str, Any]:
    """A scene of these objects in the daylight that files without a scene have, framed."""
    return {
        "quiltd": 1,
        "camera": {"fit": True, "cone": 35},
        "lights": {
            "sky": {"type": "environment", "radiance": [0.25, 0.33, 0.45], "visible": False},
            "sun": {"type": "distant", "direction": [0.6, -1, -0.5], "irradiance": [4, 3.7, 3.3], "angle": 0.5},
        },
        "backdrop": [0.08, 0.1, 0.14],
        **objects,
    }


def refuse_arrays(where: str, keys: Dict[str, Any], known: Sequence[str] = ()) -> None:
    """Arrays under keys that take none would become long lists. known: the keys that take one."""
    for key, value in keys.items():
        if isinstance(value, dict):
            refuse_arrays(f"{where}: {key}", value)
        shape = getattr(value, "shape", None) or ()
        if isinstance(shape, tuple) and (len(shape) > 2 or math.prod(shape) > MATRIX):
            raise ParameterError(f'{where}: the key "{key}" takes no array{did_you_mean(str(key), known)}')


def opaque_scale(parcel: arrays.Parcel, sides: Tuple[float, float, float]) -> float:
    """The scale by which the densest voxels make the volume opaque."""
    largest = parcel.largest()
    if not largest > 0:
        raise ParameterError("show: no value of the array is above 0")
    return OPTICAL_DEPTH * 3 / (largest * sum(side * count for side, count in zip(sides, parcel.shape)))


def show_volume(client: "Quiltd", array: Any, spacing: Any, scale: Optional[float], volume: Dict[str, Any]) -> Dict[str, Any]:
    if not client.takes("scene.load", "arrays"):
        raise NotSupported("show: scene.load of this quiltd has no arrays; write an OpenVDB file and load it by scene(path)")
    sides = arrays.three(spacing, "spacing")
    parcels = {"array": arrays.Parcel(array, "float32", 3, "show")}
    emission = volume.get("emission")
    if emission is not None and not isinstance(emission, dict):
        emission = {"array": emission}
    if emission is not None and not isinstance(emission.get("array", ""), str):
        parcels["emission"] = arrays.Parcel(emission["array"], "float32", 3, "emission")
        emission = {**emission, "array": "emission"}
    refuse_arrays("show", {key: value for key, value in volume.items() if key != "emission"}, ["emission"])
    refuse_arrays("emission", emission or {}, ["array"])
    if scale is None:
        scale = opaque_scale(parcels["array"], sides)
    keys = {**volume, **({} if emission is None else {"emission": emission})}
    scene = daylight(volumes={"array": {"array": "array", "spacing": list(reversed(sides)), "scale": scale, **keys}})
    return client._load("scene.load", {"scene": scene}, parcels=parcels)


def show_mesh(client: "Quiltd", mesh: Any, keys: Dict[str, Any]) -> Dict[str, Any]:
    if not client.takes("scene.patch", "arrays"):
        raise NotSupported("show: this quiltd has no arrays for meshes; write a PLY file and load it by scene(path)")
    if not isinstance(mesh, (tuple, list)) or not 2 <= len(mesh) <= len(MESH_ARRAYS):
        raise ParameterError("show: mesh is (positions, triangles), and normals and uvs if there are any")
    parcels = {}
    for name, values in zip(MESH_ARRAYS, mesh):
        if values is not None:
            kind, columns = "uint32" if name == "triangles" else "float32", 2 if name == "uvs" else 3
            parcels[name] = arrays.Parcel(values, kind, 2, name, columns)
    refuse_arrays("show", keys)
    material = keys.get("material")
    named = {"materials": {"mesh": material}} if isinstance(material, dict) else {}
    more = {**keys, "material": "mesh"} if named else keys
    scene = daylight(meshes={"mesh": {"arrays": {name: name for name in parcels}, **more}}, **named)
    return client._load("scene.load", {"scene": scene}, parcels=parcels)


def quilt_parcel(array: Any) -> arrays.Parcel:
    source = arrays.source_of(array, "show_quilt")
    if len(source.shape) != 3 or source.shape[2] != 3 or source.type != "uint8":
        remedy = "; pass (255 * array).round().astype('uint8') for values from 0 to 1" if source.family == "f" else ""
        raise ParameterError(f"show_quilt: expected (height, width, 3) of uint8, not {source.shape} of {source.type}{remedy}")
    if source.masked():
        raise ParameterError("show_quilt: values are masked; pass array.filled(0)")
    return arrays.Parcel(array, "uint8", 3, "show_quilt")


def tiles(value: Any, what: str) -> int:
    """A number of columns or rows."""
    if isinstance(value, bool) or not hasattr(value, "__index__") or not 1 <= value <= 64:
        raise ParameterError(f"show_quilt: {what}: expected a whole number from 1 to 64, not {value!r}")
    return int(value)


def show_quilt(client: "Quiltd", array: Any, columns: int, rows: int, more: Dict[str, Any]) -> Dict[str, Any]:
    if not client.takes("quilt.show"):
        raise NotSupported('show_quilt: this quiltd has no method quilt.show; write a PNG and load it by scene(path, quilt="8x6")')
    parcel, columns, rows = quilt_parcel(array), tiles(columns, "columns"), tiles(rows, "rows")
    height, width = parcel.shape[:2]
    if width % columns or height % rows:
        raise ParameterError(f"show_quilt: {width} x {height} pixels are not {columns} x {rows} tiles of one size")
    params = {"columns": columns, "rows": rows, "width": width, "height": height}
    params.update({name: value for name, value in more.items() if value is not None})
    client.checked("quilt.show", params)
    file = parcel.sealed()
    try:
        return client.call("quilt.show", params, [file])
    finally:
        arrays.close_all([file])
