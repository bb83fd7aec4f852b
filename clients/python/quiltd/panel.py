"""Arrays on the panel."""

import os
from typing import TYPE_CHECKING, Any, Dict, Optional

from . import arrays
from .errors import NotSupported, ParameterError

if TYPE_CHECKING:
    from .client import Quiltd

OPTICAL_DEPTH = 8.0  # of a volume full of its densest value, seen through its mean side


def volume_scene(volume: Dict[str, Any]) -> Dict[str, Any]:
    """A volume in the daylight that files without a scene have, framed."""
    return {
        "quiltd": 1,
        "camera": {"fit": True, "cone": 35},
        "volumes": {"array": volume},
        "lights": {
            "sky": {"type": "environment", "radiance": [0.25, 0.33, 0.45], "visible": False},
            "sun": {"type": "distant", "direction": [0.6, -1, -0.5], "irradiance": [4, 3.7, 3.3], "angle": 0.5},
        },
        "backdrop": [0.08, 0.1, 0.14],
    }


def show_volume(client: "Quiltd", array: Any, spacing: Any, scale: Optional[float], volume: Dict[str, Any]) -> Dict[str, Any]:
    if not client.takes("scene.load", "arrays"):
        raise NotSupported("show: scene.load of this quiltd has no arrays; write an OpenVDB file and load it by scene(path)")
    array = arrays.as_float32(array)
    view = arrays.view_of(array, 3, "show")
    sides = arrays.three(spacing, "spacing")
    floats = arrays.floats_of(view)
    if scale is None:
        largest = arrays.largest_of(array, floats)
        if not largest > 0:
            raise ParameterError("show: no value of the array is above 0")
        extent = sum(side * count for side, count in zip(sides, view.shape or ())) / 3
        scale = OPTICAL_DEPTH / (largest * extent)
    scene = volume_scene({"array": "array", "spacing": list(reversed(sides)), "scale": scale, **volume})
    parcel = {"array": {"shape": list(view.shape or ()), "type": "float32"}}
    file = arrays.sealed(floats)
    try:
        return client.call("scene.load", {"scene": scene, "arrays": parcel}, [file])
    finally:
        os.close(file)


def show_quilt(client: "Quiltd", array: Any, columns: int, rows: int, aspect: Optional[float]) -> Dict[str, Any]:
    if not client.takes("quilt.show"):
        raise NotSupported('show_quilt: this quiltd has no method quilt.show; write a PNG and load it by scene(path, quilt="8x6")')
    view = arrays.view_of(array, 3, "show_quilt")
    height, width, channels = view.shape or (0, 0, 0)
    if channels != 3 or view.itemsize != 1:
        raise ParameterError(f"show_quilt: expected (height, width, 3) of uint8, not {view.shape} of type {view.format}")
    if width % columns or height % rows:
        raise ParameterError(f"show_quilt: {width} x {height} pixels are not {columns} x {rows} tiles of one size")
    params = {"columns": columns, "rows": rows, "format": "raw", "width": width, "height": height}
    file = arrays.sealed(view.tobytes())
    try:
        return client.call("quilt.show", {**params, **({} if aspect is None else {"aspect": aspect})}, [file])
    finally:
        os.close(file)
