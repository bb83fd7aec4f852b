"""Arrays from memory: what arrives at the daemon is what was in them, in C order, and nobody can change it."""

import array
import ctypes
import fcntl
import json
import os
import struct
import tempfile
import unittest
from unittest import mock

try:
    import numpy
except ImportError:
    numpy = None

import quiltd
from fake import FakeCase, floats, whole
from quiltd import arrays


class Interface:
    """An array that has __array_interface__ alone."""

    def __init__(self, values, shape, kind="<f4", strides=None):
        self.memory = (ctypes.c_char * len(values)).from_buffer_copy(values)
        self.__array_interface__ = {"version": 3, "data": (ctypes.addressof(self.memory), False), "shape": shape, "typestr": kind, "strides": strides}


class Views(unittest.TestCase):
    def sent(self, values, kind="float32", dimensions=3):
        """The values as they arrive at quiltd."""
        file = arrays.Parcel(values, kind, dimensions, "a").sealed()
        self.addCleanup(os.close, file)
        return list(memoryview(arrays.contents(file)).cast("I" if kind == "uint32" else "f"))

    def test_every_type_becomes_float32(self):
        for code in "fdBbHhIiLlQq":
            view = memoryview(array.array(code, range(6))).cast("B").cast(code, (1, 2, 3))
            self.assertEqual(self.sent(view), [0, 1, 2, 3, 4, 5], code)

    def test_bool_is_0_and_1(self):
        self.assertEqual(self.sent(memoryview(bytes([0, 1])).cast("?", (1, 1, 2))), [0, 1])

    def test_other_byte_orders_and_steps_are_read(self):
        self.assertEqual(self.sent((ctypes.c_float * 2 * 1 * 1)(((3, 4),))), [3, 4])

    def test_whole_numbers_become_uint32(self):
        for code in "bBhHiIlLqQ":
            self.assertEqual(self.sent(whole((2, 3), range(6), code), "uint32", 2), [0, 1, 2, 3, 4, 5], code)

    def test_what_no_index_can_be_is_named(self):
        for value, says in ((-1, "-1"), ((1 << 32) + 2, "4294967298")):
            with self.assertRaisesRegex(quiltd.ParameterError, rf"^a: the value at \[1, 2\] is {says}; expected whole numbers from 0 to 4294967295"):
                self.sent(whole((2, 3), [0, 1, 2, 0, 1, value]), "uint32", 2)
        with self.assertRaisesRegex(quiltd.ParameterError, r"^a: values of type float32 are not read; pass a.astype\('uint32'\)"):
            self.sent(floats((1, 3), [0, 1, 2]), "uint32", 2)

    def test_what_float32_cannot_hold_is_named(self):
        for value, says in ((float("nan"), "nan; expected finite"), (float("-inf"), "-inf; expected finite"), (-1e300, "-1e.300, which float32 cannot hold")):
            with self.subTest(value), self.assertRaisesRegex(quiltd.ParameterError, rf"the value at \[0, 1, 0\] is {says}"):
                self.sent(memoryview(array.array("d", [1, 2, value, 3])).cast("B").cast("d", (1, 2, 2)))

    def test_arrays_are_read_in_slabs(self):
        with mock.patch.object(arrays, "SLAB", 5):
            self.assertEqual(self.sent(whole((2, 3, 4), range(24))), list(range(24)))
            with self.assertRaisesRegex(quiltd.ParameterError, r"\[1, 2, 2\] is -1"):
                self.sent(whole((2, 3, 4), [*range(22), -1, 0]), "uint32")
            self.assertEqual(arrays.Parcel(whole((2, 3, 4), range(24)), "float32", 3, "a").largest(), 23)

    def test_the_type_of_an_array_follows_from_its_values(self):
        for values, kind in ((whole((2, 3), range(6)), "uint32"), (floats((2, 3), range(6)), "float32"), (whole((1, 2, 3), range(6)), "float32")):
            parcel = arrays.parcel_by_type(values, "a")
            self.assertEqual((parcel.kind, parcel.shape), (kind, values.shape))

    def test_the_array_interface_is_read(self):
        self.assertEqual(self.sent(Interface(struct.pack("<2f", 3, 4), (1, 1, 2))), [3, 4])
        self.assertEqual(self.sent(Interface(struct.pack("<2q", 3, 4), (1, 1, 2), "<i8")), [3, 4])

    def test_sizes_are_checked_before_anything_is_read(self):
        huge = Interface(b"12345678", (1 << 11, 1 << 11, (1 << 10) + 1))
        with self.assertRaisesRegex(quiltd.ParameterError, r"^a: the shape .* needs 16.0 GiB as float32; at most 16 GiB are read"):
            arrays.Parcel(huge, "float32", 3, "a")

    def test_others_are_refused(self):
        for values in (
            [[[1.0]]],
            "text",
            floats((2, 2), [1, 2, 3, 4]),
            Interface(b"12345678", (1, 1, 2), strides=(8, 8, 4)),
            Interface(b"12345678", (1, 1, 2), ">f4"),
            Interface(b"", (0, 1, 2)),
            memoryview(b"12").cast("c", (1, 1, 2)),
        ):
            with self.subTest(values), self.assertRaisesRegex(quiltd.ParameterError, "^a: "):
                arrays.Parcel(values, "float32", 3, "a")

    def test_spacing_is_one_or_three_positive_numbers(self):
        self.assertEqual(arrays.three(2, "spacing"), (2, 2, 2))
        self.assertEqual(arrays.three((1, 2, 3), "spacing"), (1, 2, 3))
        for wrong in (0, -1, (1, 2), (1, 2, 0), float("nan"), "1mm", "111", ("1", "1", "1"), None, object(), 1j):
            with self.subTest(wrong), self.assertRaises(quiltd.ParameterError):
                arrays.three(wrong, "spacing")

    def test_memory_files_are_sealed(self):
        file = arrays.sealed([b"ab", floats((1, 1, 1), [1])])
        self.addCleanup(os.close, file)
        self.assertEqual(arrays.contents(file), b"ab" + struct.pack("f", 1))
        self.assertTrue(fcntl.fcntl(file, fcntl.F_GET_SEALS) & fcntl.F_SEAL_WRITE)
        with self.assertRaises(PermissionError):
            os.write(file, b"x")


class Sent(FakeCase):
    """bytes: of the descriptors that came."""

    def setUp(self):
        super().setUp()
        self.bytes = []

        def load(params, files):
            for file in files:
                self.bytes.append(arrays.contents(file))
            return {"generation": 2, "warnings": []}

        self.fake.answers.update({"scene.load": load, "scene.patch": load, "quilt.show": load})


class Shown(Sent):
    def test_a_volume_is_sent_with_its_shape(self):
        values = [float(i) for i in range(24)]
        answer = self.q.show(floats((2, 3, 4), values), spacing=(3, 2, 1), scale=5, albedo=[1, 0.5, 0.25])
        self.assertEqual(answer["generation"], 2)
        (params,) = self.sent("scene.load")
        self.assertEqual(params["arrays"], {"array": {"shape": [2, 3, 4], "type": "float32"}})
        volume = {"array": "array", "spacing": [1, 2, 3], "scale": 5, "albedo": [1, 0.5, 0.25]}
        self.assertEqual(params["scene"]["volumes"], {"array": volume})
        self.assertEqual(self.bytes, [struct.pack("24f", *values)])

    def test_the_scale_makes_it_opaque(self):
        self.q.show(floats((2, 2, 2), [0.5] * 8), spacing=4)
        scale = self.sent("scene.load")[0]["scene"]["volumes"]["array"]["scale"]
        self.assertAlmostEqual(scale * 0.5 * 8, 8)  # density times length

    def test_an_empty_volume_is_refused(self):
        with self.assertRaisesRegex(quiltd.ParameterError, "above 0"):
            self.q.show(floats((1, 1, 2), [0, 0]))
        self.assertEqual(self.sent("scene.load"), [])

    def test_a_mesh_is_sent_with_its_shapes(self):
        points, faces, uvs = floats((3, 3), range(9)), whole((1, 3), [0, 1, 2]), floats((3, 2), range(6))
        self.q.show(mesh=(points, faces, None, uvs), material={"albedo": 0.2}, normals="smooth")
        (params,) = self.sent("scene.load")
        names = {"positions": "positions", "triangles": "triangles", "uvs": "uvs"}
        self.assertEqual(params["scene"]["meshes"], {"mesh": {"arrays": names, "material": "mesh", "normals": "smooth"}})
        self.assertEqual(params["scene"]["materials"], {"mesh": {"albedo": 0.2}})
        shapes = [(name, array["shape"], array["type"]) for name, array in params["arrays"].items()]
        self.assertEqual(shapes, [("positions", [3, 3], "float32"), ("triangles", [1, 3], "uint32"), ("uvs", [3, 2], "float32")])
        self.assertEqual(self.bytes, [struct.pack("9f", *range(9)), struct.pack("3I", 0, 1, 2), struct.pack("6f", *range(6))])

    def test_other_meshes_are_refused(self):
        points, faces = floats((3, 3), range(9)), whole((1, 3), [0, 1, 2])
        for mesh in ((points,), points, (points, points), (floats((3, 2), range(6)), faces), (points, whole((1, 4), range(4))), (points, faces, None, points)):
            with self.subTest(mesh), self.assertRaises(quiltd.ParameterError):
                self.q.show(mesh=mesh)
        for arguments in ({}, {"array": floats((1, 1, 1), [1]), "mesh": (points, faces)}):
            with self.subTest(arguments), self.assertRaises(quiltd.ParameterError):
                self.q.show(**arguments)
        self.assertEqual(self.sent("scene.load"), [])

    def test_emission_is_an_array_or_has_one(self):
        ones, heat = floats((1, 1, 1), [1]), floats((1, 1, 1), [7])
        for emission, sent in ((heat, {"array": "emission"}), ({"array": heat, "scale": 2}, {"array": "emission", "scale": 2}), ({"scale": 3}, {"scale": 3})):
            self.q.show(ones, emission=emission)
            self.assertEqual(self.sent("scene.load")[-1]["scene"]["volumes"]["array"]["emission"], sent)
        self.assertEqual(self.bytes, [struct.pack("f", x) for x in (1, 7, 1, 7, 1)])

    def test_arrays_under_other_keys_are_refused(self):
        ones, heat = floats((1, 1, 1), [1]), floats((1, 1, 1), [7])
        triangle = (floats((3, 3), range(9)), whole((1, 3), [0, 1, 2]))
        for says, keys in (
            ('^emission: the key "arr" takes no array; did you mean "array"', {"array": ones, "emission": {"arr": heat}}),
            ('^show: the key "emision" takes no array; did you mean "emission"', {"array": ones, "emision": heat}),
            ('^show: material: the key "albedo" takes no array$', {"mesh": triangle, "material": {"albedo": heat}}),
            ('^show: the key "material" takes no array$', {"mesh": triangle, "material": floats((6, 3), range(18))}),
        ):
            with self.subTest(says), self.assertRaisesRegex(quiltd.ParameterError, says):
                self.q.show(**keys)
        self.assertEqual(self.sent("scene.load"), [])

    def test_what_is_of_volumes_is_refused_with_meshes(self):
        triangle = (floats((3, 3), range(9)), whole((1, 3), [0, 1, 2]))
        for name in ("spacing", "scale"):
            with self.assertRaisesRegex(quiltd.ParameterError, f"show: {name} is for volumes"):
                self.q.show(mesh=triangle, **{name: 1})

    def test_a_volume_with_nan_is_told_its_place(self):
        for scale in (None, 2):
            with self.assertRaisesRegex(quiltd.ParameterError, r"^show: the value at \[0, 0, 1\] is nan"):
                self.q.show(floats((1, 1, 2), [0, float("nan")]), scale=scale)

    def test_a_patch_has_arrays(self):
        patch = {"volumes": {"a": {"array": "b"}}}
        self.q.scene.patch(patch, arrays={"b": floats((1, 1, 2), [1, 2]), "t": whole((1, 3), [0, 1, 2])})
        arrays = {"b": {"shape": [1, 1, 2], "type": "float32"}, "t": {"shape": [1, 3], "type": "uint32"}}
        self.assertEqual(self.sent("scene.patch"), [{"patch": patch, "arrays": arrays}])
        self.assertEqual(self.bytes, [struct.pack("2f", 1, 2), struct.pack("3I", 0, 1, 2)])
        self.q.scene.patch(patch)
        self.assertEqual(self.sent("scene.patch")[-1], {"patch": patch})

    def test_a_quilt_is_sent_row_by_row(self):
        picture = bytes(range(36))
        self.q.show_quilt(memoryview(picture).cast("B", (2, 6, 3)), 3, 2, aspect=0.75, views=5, name="plot")
        params = {"columns": 3, "rows": 2, "width": 6, "height": 2, "aspect": 0.75, "views": 5, "name": "plot"}
        self.assertEqual(self.sent("quilt.show"), [params])
        self.assertEqual(self.bytes, [picture])

    def test_other_quilts_are_refused(self):
        for values, shape, columns in ((bytes(8), (1, 2, 4), 2), (bytes(9), (1, 3, 3), 2)):
            with self.subTest(shape), self.assertRaises(quiltd.ParameterError):
                self.q.show_quilt(memoryview(values).cast("B", shape), columns, 1)
        for code in "?b":
            with self.subTest(code), self.assertRaisesRegex(quiltd.ParameterError, r"of uint8, not \(1, 2, 3\) of (bool|int8)$"):
                self.q.show_quilt(memoryview(bytes(6)).cast(code, (1, 2, 3)), 2, 1)
        with self.assertRaisesRegex(quiltd.ParameterError, r"not \(1, 2, 3\) of float32; pass \(255 \* array\)"):
            self.q.show_quilt(floats((1, 2, 3), range(6)), 2, 1)
        for columns in (0, True, 1.5, "2"):
            with self.subTest(columns), self.assertRaisesRegex(quiltd.ParameterError, "columns: expected a whole number"):
                self.q.show_quilt(memoryview(bytes(6)).cast("B", (1, 2, 3)), columns, 1)
        self.assertEqual(self.sent("quilt.show"), [])

    def test_without_a_client_it_connects(self):
        with mock.patch.dict(os.environ, {"QUILTD_SOCKET": self.fake.path}):
            quiltd.show(floats((1, 1, 1), [1])).close()
            quiltd.show_quilt(memoryview(bytes(6)).cast("B", (1, 2, 3)), 2, 1).close()
            with self.assertRaises(quiltd.ParameterError):
                quiltd.show(floats((1, 1, 1), [0]))
        self.assertEqual(len(self.bytes), 2)

    def test_a_document_goes_by_value(self):
        document = {"quiltd": 1, "camera": {"views": 3}}
        self.q.scene(document)
        self.assertEqual(self.sent("scene.load"), [{"scene": document}])

    def test_a_long_document_goes_by_descriptor(self):
        document = {"quiltd": 1, "comment": "x" * (1 << 20)}
        with tempfile.NamedTemporaryFile() as file:
            file.write(b"a mesh")
            file.flush()
            self.q.scene(document, files=[file.name], name="long")
        self.assertEqual(self.sent("scene.load"), [{"scene_fd": True, "name": "long", "files": [file.name]}])
        self.assertEqual((json.loads(self.bytes[0]), self.bytes[1]), (document, b"a mesh"))

    def test_a_file_is_passed_unless_quiltd_may_read_it(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("a.json", "b.obj"):
                with open(os.path.join(folder, name), "w") as file:
                    file.write(name)
            a, b = os.path.join(folder, "a.json"), os.path.join(folder, "b.obj")
            self.q.scene(a, files=[b])
            self.q.info["folders"] = [folder]
            self.q.scene(a, files=[b])
            self.q.scene(folder + "/")
        self.assertEqual(self.sent("scene.load"), [{"file": a, "files": [a, b]}, {"file": a}, {"file": folder + "/"}])
        self.assertEqual(self.bytes, [b"a.json", b"b.obj"])


@unittest.skipIf(numpy is None, "there is no numpy")
class Numpy(Sent):
    def test_masked_values_of_volumes_are_0(self):
        self.q.show(numpy.ma.masked_invalid([[[1, float("nan"), 3]]]), spacing=1)
        self.assertEqual(self.bytes, [struct.pack("3f", 1, 0, 3)])
        self.q.scene({"quiltd": 1}, arrays={"a": numpy.ma.array([[[1, 9]]], mask=[[[0, 1]]])})
        self.assertEqual(self.bytes[-1], struct.pack("2f", 1, 0))

    def test_masked_values_of_meshes_are_refused(self):
        points = numpy.ma.array(numpy.zeros((3, 3)))
        self.q.show(mesh=(points, numpy.array([[0, 1, 2]])))
        points[1, 1] = numpy.ma.masked
        with self.assertRaisesRegex(quiltd.ParameterError, "^positions: values are masked"):
            self.q.show(mesh=(points, numpy.array([[0, 1, 2]])))
        with self.assertRaisesRegex(quiltd.ParameterError, "^show_quilt: values are masked"):
            self.q.show_quilt(numpy.ma.array(numpy.zeros((1, 2, 3), "u1"), mask=True), 2, 1)

    def test_every_type_becomes_float32(self):
        for kind in ("f2", "f4", ">f4", "f8", "longdouble", "i1", "u2", ">i4", "u8", "?"):
            self.q.show(numpy.ones((2, 1, 3), kind).transpose(2, 1, 0))
            self.assertEqual(self.bytes[-1], struct.pack("6f", *[1] * 6), kind)
        self.q.show(numpy.arange(6.0).reshape(1, 2, 3).transpose(2, 1, 0), spacing=1)
        self.assertEqual(self.bytes[-1], struct.pack("6f", 0, 3, 1, 4, 2, 5))

    def test_other_types_are_named(self):
        for kind, says in (
            ("c8", "complex64 are not read; pass array.real"),
            ("M8[s]", r"datetime64\[s\] are not read"),
            ("f4,i4", "structure are not read; pass one field"),
            ("O", "object are not read; pass array.astype"),
        ):
            with self.subTest(kind), self.assertRaisesRegex(quiltd.ParameterError, f"^show: values of type {says}"):
                self.q.show(numpy.zeros((1, 1, 1), kind))
        with self.assertRaisesRegex(quiltd.ParameterError, r"^triangles: values of type float64 are not read; pass triangles.astype\('uint32'\)"):
            self.q.show(mesh=(numpy.zeros((3, 3)), numpy.zeros((1, 3))))

    def test_wrong_values_are_named(self):
        for kind, value, says in (("f4", "nan", "nan; expected finite"), ("f2", "inf", "inf; expected finite"), ("f8", 1e300, "1e.300, which float32 cannot hold")):
            values = numpy.zeros((3, 4, 5), kind)
            values[2, 1, 3] = value
            for slab in (7, 1000):
                with mock.patch.object(arrays, "SLAB", slab), self.assertRaisesRegex(quiltd.ParameterError, rf"\[2, 1, 3\] is {says}"):
                    self.q.show(values, scale=1)
        for value in (-1, (1 << 32) + 2):
            with self.assertRaisesRegex(quiltd.ParameterError, rf"^triangles: the value at \[0, 2\] is {value}; expected whole numbers"):
                self.q.show(mesh=(numpy.zeros((3, 3)), numpy.array([[0, 1, value]])))

    def test_a_huge_array_is_not_read(self):
        with self.assertRaisesRegex(quiltd.ParameterError, "needs 4096.0 GiB as float32; at most 16 GiB"):
            self.q.show(numpy.broadcast_to(numpy.float64(1), (1 << 14, 1 << 14, 1 << 12)))

    def test_a_broadcast_array_is_written_in_slabs(self):
        with mock.patch.object(arrays, "SLAB", 64):
            sizes = [len(values) for values, _ in arrays.Parcel(numpy.broadcast_to(numpy.float64(1), (3, 10, 20)), "float32", 3, "a")._slabs()]
        self.assertLessEqual(max(sizes), 256)
        self.assertEqual(sum(sizes), 2400)

    def test_a_spacing_may_be_of_numpy(self):
        self.q.show(numpy.ones((1, 1, 1)), spacing=numpy.float32(2))
        self.q.show(numpy.ones((1, 1, 1)), spacing=numpy.array(2))
        self.q.show(numpy.ones((1, 1, 1)), spacing=numpy.array([3, 2, 1]))
        spacings = [params["scene"]["volumes"]["array"]["spacing"] for params in self.sent("scene.load")]
        self.assertEqual(spacings, [[2, 2, 2], [2, 2, 2], [1, 2, 3]])


class Older(FakeCase):
    without = ("frame.get", "quilt.show")

    def test_what_quiltd_lacks_is_said(self):
        properties = self.q.info["methods"]["scene.load"]["params"]["properties"]
        del properties["scene"], properties["arrays"]
        del self.q.info["methods"]["scene.patch"]["params"]["properties"]["arrays"]
        for call in (
            lambda: self.q.scene({"quiltd": 1}),
            lambda: self.q.show(floats((1, 1, 1), [1])),
            lambda: self.q.show(mesh=(floats((3, 3), range(9)), whole((1, 3), [0, 1, 2]))),
            lambda: self.q.show_quilt(memoryview(bytes(6)).cast("B", (1, 2, 3)), 2, 1),
            self.q.preview,
            self.q.array,
            self.q.widget,
        ):
            with self.assertRaises(quiltd.NotSupported):
                call()


if __name__ == "__main__":
    unittest.main()
