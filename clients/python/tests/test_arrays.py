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

import quiltd
from fake import FakeCase, floats, whole
from quiltd import arrays


class Interface:
    """An array that has __array_interface__ alone."""

    def __init__(self, values, shape, kind="<f4", strides=None):
        self.memory = (ctypes.c_char * len(values)).from_buffer_copy(values)
        self.__array_interface__ = {"version": 3, "data": (ctypes.addressof(self.memory), False), "shape": shape, "typestr": kind, "strides": strides}


class Views(unittest.TestCase):
    def floats(self, values):
        return list(arrays.values_of(arrays.view_of(values, 3, "show")))

    def test_every_type_becomes_float32(self):
        for code in "fdBbHhIiLlQq":
            view = memoryview(array.array(code, range(6))).cast("B").cast(code, (1, 2, 3))
            self.assertEqual(self.floats(view), [0, 1, 2, 3, 4, 5], code)

    def test_bool_is_0_and_1(self):
        self.assertEqual(self.floats(memoryview(bytes([0, 1])).cast("?", (1, 1, 2))), [0, 1])

    def test_float32_is_not_copied(self):
        values = floats((1, 1, 2), [1, 2])
        copy = arrays.values_of(arrays.view_of(values, 3, "show"))
        values[0, 0, 0] = 5
        self.assertEqual(copy[0], 5)

    def test_whole_numbers_become_uint32(self):
        for code in "bBhHiIlLqQ":
            view = arrays.view_of(whole((2, 3), range(6), code), 2, "triangles")
            self.assertEqual(list(arrays.values_of(view, "uint32")), [0, 1, 2, 3, 4, 5], code)
        for wrong in (whole((1, 3), [0, 1, -1]), whole((1, 3), [0, 1, 1 << 32]), floats((1, 3), [0, 1, 2])):
            with self.assertRaisesRegex(quiltd.ParameterError, "triangles: expected whole numbers"):
                arrays.parcel_of(wrong, "uint32", 2, "triangles", 3)

    def test_the_type_of_an_array_follows_from_its_values(self):
        for values, kind in ((whole((2, 3), range(6)), "uint32"), (floats((2, 3), range(6)), "float32"), (whole((1, 2, 3), range(6)), "float32")):
            parcel = arrays.parcel_by_type(values, "a")
            self.assertEqual((parcel.kind, parcel.shape, list(parcel.values)), (kind, values.shape, [0, 1, 2, 3, 4, 5]))

    def test_the_array_interface_is_read(self):
        self.assertEqual(self.floats(Interface(struct.pack("<2f", 3, 4), (1, 1, 2))), [3, 4])
        self.assertEqual(self.floats(Interface(struct.pack("<2q", 3, 4), (1, 1, 2), "<i8")), [3, 4])

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
            with self.subTest(values), self.assertRaises(quiltd.ParameterError):
                arrays.view_of(values, 3, "show")

    def test_spacing_is_one_or_three_positive_numbers(self):
        self.assertEqual(arrays.three(2, "spacing"), (2, 2, 2))
        self.assertEqual(arrays.three((1, 2, 3), "spacing"), (1, 2, 3))
        for wrong in (0, -1, (1, 2), (1, 2, 0), float("nan")):
            with self.subTest(wrong), self.assertRaises(quiltd.ParameterError):
                arrays.three(wrong, "spacing")

    def test_memory_files_are_sealed(self):
        file = arrays.sealed(b"ab", floats((1, 1, 1), [1]))
        self.addCleanup(os.close, file)
        self.assertEqual(arrays.contents(file), b"ab" + struct.pack("f", 1))
        self.assertTrue(fcntl.fcntl(file, fcntl.F_GET_SEALS) & fcntl.F_SEAL_WRITE)
        with self.assertRaises(PermissionError):
            os.write(file, b"x")


class Shown(FakeCase):
    def setUp(self):
        super().setUp()
        self.bytes = []

        def load(params, files):
            for file in files:
                self.bytes.append(arrays.contents(file))
            return {"generation": 2, "warnings": []}

        self.fake.answers.update({"scene.load": load, "scene.patch": load, "quilt.show": load})

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

    def test_a_patch_has_arrays(self):
        patch = {"volumes": {"a": {"array": "b"}}}
        self.q.scene.patch(patch, arrays={"b": floats((1, 1, 2), [1, 2]), "t": whole((1, 3), [0, 1, 2])})
        arrays = {"b": {"shape": [1, 1, 2], "type": "float32"}, "t": {"shape": [1, 3], "type": "uint32"}}
        self.assertEqual(self.sent("scene.patch"), [{"patch": patch, "arrays": arrays}])
        self.assertEqual(self.bytes, [struct.pack("2f", 1, 2), struct.pack("3I", 0, 1, 2)])
        self.q.scene.patch(patch)
        self.assertEqual(self.sent("scene.patch")[-1], {"patch": patch})

    def test_arrays_convert_themselves(self):
        class Array:
            dtype = type("dtype", (), {"kind": "f"})
            __array_interface__ = Interface(b"12", (1, 1, 1), "<f2").__array_interface__

            def astype(self, kind, order, copy):
                self.asked = (kind, order, copy)
                return floats((1, 1, 1), [3])

        values = Array()
        self.q.show(values, spacing=1)
        self.assertEqual(values.asked, ("float32", "C", False))
        self.assertEqual(self.bytes, [struct.pack("f", 3)])

    def test_a_quilt_is_sent_row_by_row(self):
        picture = bytes(range(36))
        self.q.show_quilt(memoryview(picture).cast("B", (2, 6, 3)), 3, 2, aspect=0.75)
        params = {"columns": 3, "rows": 2, "width": 6, "height": 2, "aspect": 0.75}
        self.assertEqual(self.sent("quilt.show"), [params])
        self.assertEqual(self.bytes, [picture])

    def test_other_quilts_are_refused(self):
        for values, shape, columns in ((bytes(8), (1, 2, 4), 2), (bytes(9), (1, 3, 3), 2)):
            with self.subTest(shape), self.assertRaises(quiltd.ParameterError):
                self.q.show_quilt(memoryview(values).cast("B", shape), columns, 1)
        with self.assertRaises(quiltd.ParameterError):
            self.q.show_quilt(floats((1, 2, 3), range(6)), 2, 1)
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
            self.q.widget,
        ):
            with self.assertRaises(quiltd.NotSupported):
                call()


if __name__ == "__main__":
    unittest.main()
