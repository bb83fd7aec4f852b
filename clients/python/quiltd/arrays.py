"""Arrays from memory into sealed memory files: numpy's, or anything else with the buffer protocol or __array_interface__.

Shapes, types and sizes are checked before a value is read. Values are converted and written in slabs, so that no copy is whole.
"""

import array
import ctypes
import fcntl
import math
import os
import struct
import sys
from typing import Any, Iterable, Iterator, List, Optional, Sequence, Tuple, Union

from .errors import ParameterError

LARGEST = 16 << 30  # bytes of an array, as in quiltd
SLAB = 1 << 22  # values that are converted at a time
_NAMES = {
    **{"f": "float32", "d": "float64", "e": "float16", "?": "bool", "b": "int8", "h": "int16", "i": "int32", "q": "int64"},
    **{"B": "uint8", "H": "uint16", "I": "uint32", "Q": "uint64", "l": f"int{8 * struct.calcsize('l')}", "L": f"uint{8 * struct.calcsize('L')}"},
}
_INTERFACE = {"<f4": "f", "<f8": "d", "|u1": "B", "|i1": "b", "<u2": "H", "<i2": "h", "<u4": "I", "<i4": "i", "<i8": "q", "<u8": "Q", "|b1": "?"}
_KINDS = {"float32": "f", "uint32": "I", "uint8": "B"}  # what is sent, by the code of struct
_SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_WRITE | fcntl.F_SEAL_SEAL
_HIGHEST = {"float32": struct.unpack("f", b"\xff\xff\x7f\x7f")[0], "uint32": (1 << 32) - 1, "uint8": 255}

Slab = Tuple[memoryview, float]  # values as they are sent, and the largest of them


def _numpy_of(values: Any) -> Any:
    """The module numpy, for arrays that have its types: who made them has loaded it."""
    if getattr(getattr(values, "dtype", None), "kind", None) is None or not hasattr(values, "shape"):
        return None
    return sys.modules.get("numpy")


def pieces(values: Any) -> Iterator[Any]:
    """Parts of an array of numpy in C order, of at most SLAB values each."""
    row = math.prod(values.shape[1:])
    if math.prod(values.shape) <= SLAB:
        yield values
    elif row > SLAB:
        for i in range(values.shape[0]):
            yield from pieces(values[i])
    else:
        for i in range(0, values.shape[0], SLAB // row):
            yield values[i : i + SLAB // row]


class _Numpy:
    """An array of numpy, or one that numpy converts part by part."""

    def __init__(self, numpy: Any, values: Any) -> None:
        self._numpy, self._values = numpy, values
        self.shape, self.family = tuple(values.shape), values.dtype.kind
        self.type = "structure" if values.dtype.names else values.dtype.name

    def masked(self) -> bool:
        return isinstance(self._values, self._numpy.ma.MaskedArray) and bool(self._numpy.ma.is_masked(self._values))

    def slabs(self, kind: str) -> Iterator[Slab]:
        offset = 0
        for piece in pieces(self._values):
            part = self._numpy.asarray(piece.filled(0) if hasattr(piece, "filled") else piece)
            right = self._right(part, kind)
            if right is not None and not right.all():
                at = int(right.argmin())
                raise _Wrong(offset + at, part.reshape(-1)[at])
            yield memoryview(part.astype(kind, order="C", copy=False)).cast("B"), float(part.max())
            offset += part.size

    def _right(self, part: Any, kind: str) -> Any:
        if kind != "float32":
            return (part >= 0) & (part <= _HIGHEST[kind])
        if part.dtype.kind != "f":
            return None
        return self._numpy.isfinite(part) if part.dtype.itemsize <= 4 else abs(part) <= _HIGHEST[kind]


class _Buffer:
    """An array with the buffer protocol."""

    def __init__(self, view: memoryview) -> None:
        self._view, self.shape = view, tuple(view.shape or ())
        code = view.format.lstrip("@=<")
        self._code = "B" if code == "?" else code
        self.type = _NAMES.get(code, f"{view.format!r} of a buffer")
        self.family = {"f": "f", "d": "f", "?": "b"}.get(code, "i" if code in _NAMES and code != "e" else "V")

    def masked(self) -> bool:
        return False

    def slabs(self, kind: str) -> Iterator[Slab]:
        simple = self._view.c_contiguous and self._view.format.lstrip("@") in _NAMES
        values = (self._view.cast("B") if simple else memoryview(self._view.tobytes())).cast(self._code)
        low, high = (-_HIGHEST[kind] if kind == "float32" else 0), _HIGHEST[kind]
        for offset in range(0, len(values), SLAB):
            part = values[offset : offset + SLAB]
            largest = max(part)
            if not (math.isfinite(sum(part)) and low <= min(part) and largest <= high):
                for at, value in enumerate(part):
                    if not low <= value <= high:
                        raise _Wrong(offset + at, value)
            sent = part if self._code == _KINDS[kind] else memoryview(array.array(_KINDS[kind], part))
            yield sent.cast("B"), float(largest)


class _Wrong(Exception):
    """A value that cannot be sent: its place in C order, and itself."""


def _by_interface(interface: Any, what: str) -> memoryview:
    """__array_interface__ of a contiguous array in memory, which is not copied."""
    code, shape = _INTERFACE.get(interface["typestr"]), tuple(interface["shape"])
    if code is None or interface.get("strides") or not isinstance(interface.get("data"), tuple):
        raise ParameterError(f"{what}: the array is neither contiguous nor of a simple type; pass a contiguous float32 copy")
    if not math.prod(shape):
        raise ParameterError(f"{what}: the array of shape {shape} is empty")
    size = math.prod(shape) * struct.calcsize(code)
    memory = (ctypes.c_char * size).from_address(interface["data"][0])
    return memoryview(memory).cast("B").cast(code, shape)


def source_of(values: Any, what: str) -> Union[_Numpy, _Buffer]:
    """What knows an array's shape and type, and reads its values."""
    numpy = _numpy_of(values)
    if numpy is not None:
        return _Numpy(numpy, values)
    try:
        return _Buffer(memoryview(values))
    except TypeError:
        interface = getattr(values, "__array_interface__", None)
        if interface is None:
            raise ParameterError(f"{what}: {type(values).__name__} is no array; pass one of numpy") from None
        return _Buffer(_by_interface(interface, what))


def _check_type(source: Union[_Numpy, _Buffer], kind: str, what: str) -> None:
    """uint8 is checked by who asks for it."""
    if source.family in {"float32": "fiub", "uint32": "iu", "uint8": "u" + "i" * isinstance(source, _Buffer)}[kind]:
        return
    remedy = {"c": "array.real or abs(array)", "V": "one field as float32"}.get(source.family, "array.astype('float32')")
    if kind == "uint32":
        remedy = f"{what}.astype('uint32')"
    raise ParameterError(f"{what}: values of type {source.type} are not read; pass {remedy}")


class Parcel:
    """An array as a call sends it: its type and its shape; sealed() has its values. Its owner keeps the array."""

    def __init__(self, values: Any, kind: str, dimensions: Optional[int], what: str, columns: Optional[int] = None) -> None:
        """dimensions: None for any. columns: the length of the last axis."""
        source = source_of(values, what)
        self.kind, self.shape, self._source, self._what, self._owner = kind, source.shape, source, what, values
        if dimensions not in (None, len(self.shape)) or not self.shape or not math.prod(self.shape):
            raise ParameterError(f"{what}: the shape is {self.shape}, expected {dimensions or 'some'} axes that are not empty")
        if columns is not None and self.shape[-1] != columns:
            raise ParameterError(f"{what}: the shape is {self.shape}, expected (n, {columns})")
        _check_type(source, kind, what)
        size = math.prod(self.shape) * struct.calcsize(_KINDS[kind])
        if size > LARGEST:
            raise ParameterError(f"{what}: the shape {self.shape} needs {size / (1 << 30):.1f} GiB as {kind}; at most {LARGEST >> 30} GiB are read")
        if len(self.shape) < 3 and source.masked():
            raise ParameterError(f"{what}: values are masked, and only volumes may have them; pass an array without them")

    def largest(self) -> float:
        return max(largest for _, largest in self._slabs())

    def sealed(self) -> int:
        """A descriptor of a memory file with the values in C order. The caller closes it."""
        return sealed(values for values, _ in self._slabs())

    def _slabs(self) -> Iterator[Slab]:
        try:
            yield from self._source.slabs(self.kind)
        except _Wrong as wrong:
            raise ParameterError(f"{self._what}: {self._complaint(*wrong.args)}") from None
        except TypeError as error:  # of arrays that numpy does not convert, such as those of a GPU
            raise ParameterError(f"{self._what}: numpy does not read the array: {error}") from None

    def _complaint(self, place: int, value: Any) -> str:
        index: List[int] = []
        for count in reversed(self.shape):
            place, rest = divmod(place, count)
            index.insert(0, rest)
        text = f"the value at {index} is {value}"
        if self.kind != "float32":
            return f"{text}; expected whole numbers from 0 to {_HIGHEST[self.kind]}"
        return f"{text}, which float32 cannot hold; scale the array" if math.isfinite(value) else f"{text}; expected finite values"


def parcel_by_type(values: Any, what: str) -> Parcel:
    """Whole numbers in two axes are triangles; all others are float32."""
    source = source_of(values, what)
    return Parcel(values, "uint32" if source.family in ("i", "u") and len(source.shape) == 2 else "float32", None, what)


def sealed(parts: Iterable[Union[bytes, memoryview, "array.array[Any]"]]) -> int:
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
    try:
        given = list(value) if hasattr(value, "__iter__") and getattr(value, "ndim", 1) > 0 else [value] * 3
        values = [float("nan") if isinstance(v, str) else float(v) for v in given]
    except (TypeError, ValueError):
        values = []
    if len(values) != 3 or not all(v > 0 and math.isfinite(v) for v in values):
        raise ParameterError(f"{what}: expected a positive number, or one for each axis, not {value!r}")
    return values[0], values[1], values[2]
