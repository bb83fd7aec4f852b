"""Parameters are checked before they are sent, by the schemas of `hello`."""

import inspect
import math
import unittest

from fake import FakeCase
from quiltd import MethodNotFound, ParameterError
from quiltd.schema import check, names_of, signature

SCHEMA = {
    "additionalProperties": False,
    "required": ["to"],
    "properties": {
        "to": {"type": "integer", "minimum": 0, "maximum": 9, "unit": "frames"},
        "from": {"type": "integer"},
        "zoom": {"type": "number", "minimum": 0.5},
        "point": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
        "level": {"type": "string", "enum": ["coarse", "complete"]},
        "exposure": {"type": ["string", "number"], "words": ["auto"]},
        "bits": {"type": "integer", "enum": [8, 16]},
        "integrator": {"type": "string", "enum": ["mvpt"], "refused": {"restir": "is a reference mode"}},
        "loop": {"type": "boolean", "default": True},
        "patch": {"type": "object", "additionalProperties": True},
        "rate": {"type": "number", "deprecated": True},
    },
}


class Scalar:
    """A number of numpy, or an array of it."""

    def __init__(self, value):
        self.value = value

    def tolist(self):
        return self.value


class Values(unittest.TestCase):
    def accept(self, **params):
        return check("m", {"to": 1, **params}, SCHEMA)

    def test_good_values_stay(self):
        good = {"zoom": 2, "point": [1, 2.5, -3], "level": "coarse", "exposure": "auto", "bits": 16, "loop": False, "patch": {"a": None}}
        self.assertEqual(self.accept(**good), {"to": 1, **good})

    def test_numbers_of_numpy_are_numbers(self):
        sent = self.accept(zoom=Scalar(1.5), point=Scalar([1.0, 2.0, 3.0]), loop=Scalar(True))
        self.assertEqual(sent, {"to": 1, "zoom": 1.5, "point": [1.0, 2.0, 3.0], "loop": True})

    def test_tuples_are_arrays(self):
        self.assertEqual(self.accept(point=(1, 2, 3))["point"], [1, 2, 3])

    def test_bad_values_are_refused(self):
        for params, word in [
            ({"zom": 1}, 'unknown parameter "zom"; did you mean "zoom"'),
            ({"to": 10}, "out of range: 0 to 9 frames"),
            ({"to": 1.5}, "expected integer"),
            ({"to": True}, "expected integer"),
            ({"zoom": "2"}, "expected number"),
            ({"zoom": math.nan}, "expected number"),
            ({"zoom": math.inf}, "expected number"),
            ({"zoom": 0.25}, "out of range"),
            ({"point": [1, 2]}, "2 values, expected 3"),
            ({"point": [1, 2, "3"]}, r"point\[2\]: expected number"),
            ({"level": "complet"}, 'did you mean "complete"'),
            ({"exposure": "bright"}, "none of auto"),
            ({"bits": 9}, "out of range: 8, 16"),
            ({"integrator": "restir"}, "restir is a reference mode"),
            ({"loop": 1}, "expected boolean"),
            ({"patch": []}, "expected object"),
        ]:
            with self.subTest(params), self.assertRaisesRegex(ParameterError, word):
                self.accept(**params)

    def test_a_missing_parameter_is_refused(self):
        with self.assertRaisesRegex(ParameterError, '"to" is missing'):
            check("m", {}, SCHEMA)


class Names(unittest.TestCase):
    def test_words_of_python_have_an_underscore(self):
        self.assertEqual(names_of("m", SCHEMA, [], {"from_": 1, "to": 2}), {"from": 1, "to": 2})

    def test_required_ones_may_come_by_position(self):
        self.assertEqual(names_of("m", SCHEMA, [5], {"zoom": 1}), {"to": 5, "zoom": 1})

    def test_others_may_not(self):
        with self.assertRaisesRegex(ParameterError, "parameters have names"):
            names_of("m", SCHEMA, [5, 6], {})
        with self.assertRaisesRegex(ParameterError, "given twice"):
            names_of("m", SCHEMA, [5], {"to": 6})

    def test_none_leaves_one_out(self):
        self.assertEqual(names_of("m", SCHEMA, [], {"to": 1, "zoom": None}), {"to": 1})

    def test_signatures_show_the_parameters(self):
        parameters = signature(SCHEMA).parameters
        self.assertEqual(list(parameters)[:2], ["to", "from_"])
        self.assertNotIn("rate", parameters)
        self.assertIs(parameters["to"].annotation, int)
        self.assertIs(parameters["loop"].default, True)


class Attributes(FakeCase):
    def test_methods_are_attributes(self):
        self.q.camera.orbit(yaw=15)
        self.assertEqual(self.sent("camera.orbit"), [{"yaw": 15}])
        self.assertIn("yaw", inspect.signature(self.q.camera.orbit).parameters)
        self.assertIn("orbit", dir(self.q.camera))
        self.assertIn("camera", dir(self.q))
        self.assertTrue(self.q.camera.orbit.__doc__.startswith("camera.orbit"))

    def test_what_is_wrong_is_not_sent(self):
        before = len(self.fake.calls)
        with self.assertRaises(ParameterError):
            self.q.camera.orbit(yaww=15)
        with self.assertRaises(ParameterError):
            self.q.call("status", {"x": 1})
        for name in ("fly", "call"):
            with self.assertRaisesRegex(MethodNotFound, "no method"):
                getattr(self.q.camera, name)
        with self.assertRaises(AttributeError):
            self.q.fly()
        with self.assertRaises(MethodNotFound):
            self.q.call("camera.fly")
        self.assertEqual(len(self.fake.calls), before)


if __name__ == "__main__":
    unittest.main()
