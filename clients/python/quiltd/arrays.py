"""Arrays from memory into sealed memory files: numpy's, or anything else with the buffer protocol or __array_interface__."""

import array
import ctypes
import fcntl
import math
import os
import struct
from typing import Any, List, Optional, Sequence, Tuple, Union

from .errors import ParameterError

_CODES = "fdBbHhIiLlQq?"  # of types that array.array has, and bool
_INTERFACE = {"<f4": "f", "<f8": "d", "|u1": "B", "|i1": "b", "<u2": "H", "<i2": "h", "<u4": "I", "<i4": "i", "<i8": "q", "<u8": "Q", "|b1": "?"}
_TYPES = {"float32": "f", "uint32": "I"}
_SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_WRITE | fcntl.F_SEAL_SEAL

Values = Union[memoryview, "array.array[Any]"]


def _by_interface(interface: Any) -> memoryview:
    """__array_interface__ of a contiguous array in memory."""
    kind, shape = _INTERFACE.get(interface["typestr"]), tuple(interface["shape"])
    if kind is None or interface.get("strides") or not isinstance(interface.get("data"), tuple):
        raise ParameterError("the array is neither contiguous nor of a simple type: pass a contiguous float32 copy")
    if not math.prod(shape):
        raise ParameterError(f"the array of shape {shape} is empty")
    size = math.prod(shape) * struct.calcsize(kind)
    return memoryview(ctypes.string_at(interface["data"][0], size)).cast(kind, shape)


def converted(values: Any, kind: str) -> Any:
    """Arrays of real numbers that can convert themselves, as numpy's can, as this type in C order; others as they are."""
    if getattr(getattr(values, "dtype", None), "kind", None) in (("f", "i", "u", "b") if kind == "float32" else ("i", "u")):
        return values.astype(kind, order="C", copy=False)
    return values


def view_of(values: Any, dimensions: Optional[int], what: str) -> memoryview:
    """A view of an array, with its shape. dimensions: None for any."""
    try:
        view = memoryview(values)
    except TypeError:
        interface = getattr(values, "__array_interface__", None)
        if interface is None:
            raise ParameterError(f"{what}: {type(values).__name__} is no array: pass one of numpy") from None
        view = _by_interface(interface)
    if dimensions not in (None, view.ndim) or not view.nbytes:
        raise ParameterError(f"{what}: the shape is {view.shape or ()}, expected {dimensions or 'some'} axes that are not empty")
    if view.format.lstrip("@=<") not in _CODES:
        raise ParameterError(f"{what}: values of type {view.format} are not read: pass array.astype('float32')")
    return view


def values_of(view: memoryview, kind: str = "float32") -> Values:
    """Its values as this type, in C order; a copy only if they are not that already."""
    wanted, code = _TYPES[kind], view.format.lstrip("@=<")
    if wanted == "I" and code in "fd?":
        raise ParameterError(f"expected whole numbers, not values of type {view.format}")
    if code == wanted and view.c_contiguous:
        return view.cast("B").cast(wanted)
    values = array.array("B" if code == "?" else code, view.tobytes())
    try:
        return values if code == wanted else array.array(wanted, values)
    except OverflowError:
        raise ParameterError("expected whole numbers from 0 to 4294967295") from None


class Parcel:
    """An array as a call sends it: its type, its shape, and its values."""

    def __init__(self, values: Any, kind: str, view: memoryview) -> None:
        self.kind, self.shape, self._array = kind, tuple(view.shape or ()), values
        self.values = values_of(view, kind)

    def largest(self) -> float:
        """The largest value, by the array's own method if it has one: that is fast."""
        return float(self._array.max() if hasattr(self._array, "max") else max(self.values))


def parcel_of(values: Any, kind: str, dimensions: int, what: str, columns: Optional[int] = None) -> Parcel:
    """columns: the length of the last axis."""
    values = converted(values, kind)
    view = view_of(values, dimensions, what)
    if columns is not None and (view.shape or ())[-1] != columns:
        raise ParameterError(f"{what}: the shape is {view.shape}, expected (n, {columns})")
    try:
        return Parcel(values, kind, view)
    except ParameterError as error:
        raise ParameterError(f"{what}: {error}") from None


def parcel_by_type(values: Any, what: str) -> Parcel:
    """Whole numbers in two axes are triangles; all others are float32."""
    kind = getattr(getattr(values, "dtype", None), "kind", None)
    view = None if kind else view_of(values, None, what)
    whole = kind in ("i", "u") if view is None else view.format.lstrip("@=<") in "bBhHiIlLqQ"
    dimensions = len(values.shape) if view is None else view.ndim
    return parcel_of(values, "uint32" if whole and dimensions == 2 else "float32", dimensions, what)


def sealed(*parts: Union[bytes, memoryview, "array.array[Any]"]) -> int:
    """A descriptor of a memory file with these bytes, which nobody can change any more. The caller closes it."""
    descriptor = os.memfd_create("quiltd", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    try:
        for part in parts:
            rest = memoryview(part).cast("B")
            while rest:
                rest = rest[os.write(descriptor, rest) :]
        fcntl.fcntl(descriptor, fcntl.F_ADD_SEALS, _SEALS)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def empty_files(count: int) -> List[int]:
    """Memory files for quiltd to write to."""
    files: List[int] = []
    try:
        for _ in range(count):
            files.append(os.memfd_create("quiltd", os.MFD_CLOEXEC))
    except BaseException:
        close_all(files)
        raise
    return files


def contents(descriptor: int) -> bytes:
    """All bytes of a file, from its start."""
    size, parts, offset = os.fstat(descriptor).st_size, [], 0
    while offset < size:
        part = os.pread(descriptor, size - offset, offset)
        if not part:
            break
        parts.append(part)
        offset += len(part)
    return b"".join(parts)


def close_all(descriptors: Sequence[int]) -> None:
    for descriptor in descriptors:
        os.close(descriptor)


def three(value: Any, what: str) -> Tuple[float, float, float]:
    """A positive number for all axes, or one for each."""
    values = [float(v) for v in (value if hasattr(value, "__len__") else [value] * 3)]
    if len(values) != 3 or not all(v > 0 and math.isfinite(v) for v in values):
        raise ParameterError(f"{what}: expected a positive number, or one for each axis, not {value!r}")
    return values[0], values[1], values[2]
