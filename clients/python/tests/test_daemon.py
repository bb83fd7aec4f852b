"""The client with a real quiltd, on a simulated panel: QUILTD_BUILD has its programs."""

import importlib.util
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import quiltd
from fake import floats, whole
from quiltd.panel import daylight

BUILD = os.environ.get("QUILTD_BUILD", "")
HERE = pathlib.Path(__file__).resolve().parent
VIEWS, WIDTH, HEIGHT = 6, 24, 32
CORNERS, FACES = [0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3], [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]  # a tetrahedron
SCENE = {
    "quiltd": 1,
    "camera": {"views": VIEWS, "cone": 30},
    "volumes": {"fog": {"shape": "sphere", "density": 4, "albedo": 0.9}},
    "lights": {"sky": {"type": "environment", "radiance": 0.7}},
}


def setUpModule():
    global folder, daemon, sock
    if not BUILD:
        raise unittest.SkipTest("QUILTD_BUILD names no programs")
    folder = tempfile.mkdtemp()
    scene, sock = os.path.join(folder, "scene.json"), os.path.join(folder, "s")
    pathlib.Path(scene).write_text(json.dumps(SCENE))
    options = ["--socket", sock, "--device", "sim:panel", "--view-size", f"{WIDTH}x{HEIGHT}", "--threads", "1", "--run-for", "1800"]
    daemon = subprocess.Popen([os.path.join(os.path.abspath(BUILD), "quiltd"), scene, *options], cwd=folder, stderr=subprocess.DEVNULL)
    while True:
        try:
            return quiltd.connect(sock).close()
        except quiltd.NoDaemon:
            if daemon.poll() is not None:
                raise
            time.sleep(0.02)


def tearDownModule():
    daemon.terminate()
    daemon.wait()
    shutil.rmtree(folder)


def png_size(data):
    assert data.startswith(b"\x89PNG\r\n\x1a\n"), data[:8]
    return struct.unpack(">II", data[16:24])


class Case(unittest.TestCase):
    def setUp(self):
        self.q = quiltd.connect(sock)
        self.addCleanup(self.q.close)
        self.q.scene(os.path.join(folder, "scene.json"))

    def until(self, holds):
        """Waits for what the daemon does in its own time; the limit is there for a daemon that never does it."""
        for _ in range(3000):
            if holds():
                return
            time.sleep(0.02)
        self.fail("it never came to hold")

    def need(self, method, parameter=None):
        if not self.q.takes(method, parameter):
            self.skipTest(f"this quiltd has no {parameter or method}")


class Calls(Case):
    def test_the_daemon_has_the_version_of_the_package(self):
        self.assertEqual(self.q.info["version"], quiltd.__version__)

    def test_every_method_of_hello_is_an_attribute(self):
        for name in self.q.info["methods"]:
            method = self.q
            for part in name.split("."):
                method = getattr(method, part)
            self.assertTrue(callable(method), name)
            self.assertTrue(method.__doc__, name)

    def test_the_nearest_method_is_named(self):
        for call in (lambda: self.q.camera.orbitt, lambda: self.q.call("camera.orbitt")):
            with self.assertRaisesRegex(quiltd.MethodNotFound, 'did you mean "(camera.)?orbit"'):
                call()
        with self.assertRaisesRegex(quiltd.MethodNotFound, 'did you mean "status"'):
            self.q.statu()

    def test_the_manual_of_events_has_all_words(self):
        words = self.q.events.__doc__.split("The words: ")[1].split(".")[0].split(", ")
        self.assertEqual(sorted(words), sorted({about["event"] for about in self.q.info["events"].values()}))

    def test_the_camera_turns(self):
        before = self.q.status()["generation"]
        after = self.q.orbit(yaw=15)["generation"]
        self.assertGreater(after, before)
        shown = self.q.wait("complete", timeout=120)
        self.assertEqual((shown["level"] != "coarse", shown["generation"]), (True, after))
        self.assertGreater(self.q.camera.orbit(pitch=5)["generation"], after)

    def test_parameters_are_those_of_the_daemon(self):
        self.q.render.set(denoise="off", exposure=1, guides=True)
        self.until(lambda: [self.q.status()[key] for key in ("denoise", "guides")] == ["off", True])
        self.q.render.set(denoise="on", exposure="scene", guides=False)
        for params in ({"denoised": "off"}, {"integrator": "restir"}, {"threads": -1}, {"exposure": "bright"}):
            with self.subTest(params), self.assertRaises(quiltd.ParameterError):
                self.q.render.set(**params)

    def test_the_client_and_the_daemon_refuse_alike(self):
        for method, params in (("camera.set", {"fov": 20}), ("camera.set", {"up": [1]}), ("wait", {"for": "done"}), ("scene.load", {})):
            with self.assertRaises(quiltd.ParameterError):
                self.q.call(method, params)
            with self.assertRaises(quiltd.ParameterError):
                self.q._connection.call(method, params)

    def test_a_limit_of_time_is_kept(self):
        self.q.render.set(target_error=1e-12)
        with self.assertRaises(quiltd.TimedOut):
            self.q.wait("converged", timeout=0.05)

    def test_errors_name_the_place(self):
        with self.assertRaises(quiltd.BadScene) as caught:
            self.q.scene.patch({"lights": {"sky": {"radianc": 1}}})
        self.assertEqual(caught.exception.data["pointer"], "/lights/sky/radianc")
        with self.assertRaises(quiltd.PathRefused):
            self.q.call("scene.load", {"file": "/etc/passwd.json"})

    def test_notifications_follow_a_change(self):
        with self.q.events("scene", "frame", timeout=120) as events:
            generation = self.q.orbit(yaw=1)["generation"]
            names = set()
            for event in events:
                names.add(event.name)
                if event.name == "frame" and event["generation"] >= generation:
                    break
        self.assertEqual(names, {"scene", "frame"})

    def test_threads_share_a_client(self):
        failed = []

        def turn():
            try:
                for _ in range(2):
                    self.q.wait("coarse", generation=self.q.orbit(yaw=1)["generation"], timeout=120)
            except BaseException as error:
                failed.append(error)

        threads = [threading.Thread(target=turn) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(failed, [])


class Scenes(Case):
    def test_a_file_that_does_not_exist_is_named(self):
        for call in (lambda: self.q.scene("/nowhere/a.glb"), lambda: self.q.scene({"quiltd": 1}, files=["/nowhere/a.glb"])):
            with self.assertRaisesRegex(quiltd.ParameterError, "^scene: /nowhere/a.glb does not exist"):
                call()
        with self.assertRaisesRegex(quiltd.QuiltdError, "[Nn]o such file"):  # quiltd's own folder
            self.q.scene(os.path.join(folder, "a.glb"))

    def test_a_document_is_shown(self):
        self.need("scene.load", "scene")
        self.q.scene({**SCENE, "camera": {"views": 5}}, name="five")
        self.assertEqual(self.q.scene.get()["scene"]["camera"], {"views": 5})
        self.assertEqual(self.q.status()["scene"], "five")

    def test_a_wrong_document_leaves_the_old_one(self):
        self.need("scene.load", "scene")
        with self.assertRaises(quiltd.BadScene):
            self.q.scene({"quiltd": 1, "camra": {}})
        self.assertEqual(self.q.scene.get()["scene"]["camera"], SCENE["camera"])

    def test_a_long_document_is_shown(self):
        self.need("scene.load", "scene_fd")
        materials = {f"material {i:04} {'x' * 100}": {"type": "diffuse", "albedo": [1 / 3, 2 / 3, 1 / 7]} for i in range(4000)}
        self.q.scene({**SCENE, "camera": {"views": 5}, "materials": materials})
        self.assertEqual(self.q.status()["views"], 5)

    def test_files_of_others_are_passed(self):
        with tempfile.TemporaryDirectory() as other:
            obj = os.path.join(other, "a.obj")
            pathlib.Path(obj).write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
            self.q.scene(obj, yaw=30)
            self.assertEqual(self.q.status()["passed"], [obj])
            scene = os.path.join(other, "b.json")
            pathlib.Path(scene).write_text(json.dumps({**SCENE, "meshes": {"a": {"file": "a.obj"}}}))
            with self.assertRaises(quiltd.PathRefused):
                self.q.scene(scene)
            self.q.scene(scene, files=[obj])
            self.assertEqual(sorted(self.q.status()["passed"]), [obj, scene])


class Exports(Case):
    def test_a_quilt_is_bytes(self):
        status = self.q.status()
        size = png_size(self.q.export("quilt", wait="complete", timeout=120))
        self.assertEqual(size, (status["columns"] * WIDTH, status["rows"] * HEIGHT))

    def test_the_name_chooses_the_format(self):
        self.assertTrue(self.q.export("still", file="a.jpg").startswith(b"\xff\xd8\xff"))
        self.assertTrue(self.q.export("still", file="a.exr").startswith(b"v/1\x01"))

    def test_pictures_are_one_per_view(self):
        pictures = self.q.export("pictures", wait="complete", timeout=120)
        self.assertEqual([png_size(picture) for picture in pictures], [(WIDTH, HEIGHT)] * VIEWS)

    def test_a_print_has_a_manifest(self):
        tiff, manifest = self.q.export("print", lpi=60, dpi=300, width=10, height=10, timeout=120)
        self.assertIn(tiff[:2], (b"II", b"MM"))
        self.assertIn("lpi", json.dumps(json.loads(manifest)).lower())

    def test_an_export_that_comes_too_late_is_ended(self):
        self.q.render.set(target_error=1e-12)
        with self.assertRaises(TimeoutError):
            self.q.export("still", wait="converged", timeout=0.05)
        self.until(lambda: self.q.status()["jobs"] == [])

    def test_a_refused_export_is_an_exception(self):
        with self.assertRaises(quiltd.ParameterError):
            self.q.export("still", file="a.gif")
        with self.assertRaises(quiltd.ParameterError):
            self.q.export("print")


class FromMemory(Case):
    def test_a_volume_is_shown(self):
        self.need("scene.load", "arrays")
        self.q.show(floats((2, 4, 8), [1.0] * 64), spacing=(3, 2, 1))  # z, y, x
        bounds = self.q.scene.get()["bounds"]
        for axis, half in enumerate((4.5, 5, 4.5)):  # linear interpolation reaches half a voxel further
            self.assertAlmostEqual(bounds["max"][axis], half, 4)
            self.assertAlmostEqual(bounds["min"][axis], -half, 4)
        self.assertIn(self.q.wait("complete", timeout=120)["level"], ("complete", "converged"))

    def test_a_wrong_volume_leaves_the_old_scene(self):
        self.need("scene.load", "arrays")
        with self.assertRaises(quiltd.BadScene):
            self.q.show(floats((1, 1, 2), [1, -1]), scale=1)
        self.assertEqual(self.q.scene.get()["scene"]["camera"], SCENE["camera"])

    def test_a_volume_glows(self):
        self.need("scene.patch", "arrays")
        ones, heat = floats((2, 2, 2), [1] * 8), floats((2, 2, 2), range(8))
        self.q.show(ones, emission=heat)
        self.q.show(ones, emission={"array": heat, "scale": 20, "temperature_scale": 300})
        emission = self.q.scene.get()["scene"]["volumes"]["array"]["emission"]
        self.assertEqual(emission, {"array": "emission", "scale": 20, "temperature_scale": 300})
        with self.assertRaisesRegex(quiltd.BadScene, "expected float32 values of shape"):
            self.q.show(ones, emission=floats((1, 1, 2), [1, 2]))

    def test_a_mesh_is_shown(self):
        self.need("scene.patch", "arrays")
        points, faces = floats((4, 3), CORNERS), whole((4, 3), FACES)
        self.q.show(mesh=(points, faces), material={"albedo": [0.8, 0.2, 0.1]}, normals="smooth")
        self.assertEqual([round(x, 5) for x in self.q.scene.get()["bounds"]["max"]], [1, 2, 3])
        self.assertIn(self.q.wait("complete", timeout=120)["level"], ("complete", "converged"))
        self.q.show(mesh=(points, faces, points, floats((4, 2), range(8))))
        for wrong in (whole((4, 3), [*FACES[:-1], 4]), whole((1, 3), [0, 1, 9])):
            with self.assertRaisesRegex(quiltd.BadScene, "there are 4 positions"):
                self.q.show(mesh=(points, wrong))
        with self.assertRaisesRegex(quiltd.ParameterError, r"positions: the value at \[3, 2\] is nan"):
            self.q.show(mesh=(floats((4, 3), [*CORNERS[:-1], float("nan")]), faces))
        self.assertEqual([round(x, 5) for x in self.q.scene.get()["bounds"]["max"]], [1, 2, 3])

    def test_scenes_and_patches_have_arrays(self):
        self.need("scene.patch", "arrays")
        mesh = {"arrays": {"positions": "p", "triangles": "t"}}
        arrays = {"p": floats((4, 3), CORNERS), "t": whole((4, 3), FACES, "i")}
        self.q.scene({"quiltd": 1, "meshes": {"m": mesh}, "lights": SCENE["lights"]}, arrays=arrays)
        self.assertEqual(sorted(self.q.status()["passed"]), ["p", "t"])
        self.q.scene.patch({"meshes": {"m": mesh}}, arrays={"p": floats((4, 3), [2 * x for x in CORNERS])})
        self.assertEqual([round(x, 5) for x in self.q.scene.get()["bounds"]["max"]], [2, 4, 6])
        self.q.scene.patch({"meshes": {"m": {"transform": {"scale": 0.5}}}})
        self.assertEqual([round(x, 5) for x in self.q.scene.get()["bounds"]["max"]], [1, 2, 3])

    def test_the_scene_of_volumes_is_one_that_quiltd_reads(self):
        scene = pathlib.Path(folder, "volume.json")
        volume = {"shape": "box", "density": 3, "albedo": [1, 0.8, 0.6]}
        scene.write_text(json.dumps(daylight(volumes={"box": volume})))
        self.q.scene(scene)
        self.assertIn(self.q.wait("complete", timeout=120)["level"], ("complete", "converged"))

    def test_a_quilt_is_shown(self):
        self.need("quilt.show")
        self.q.show_quilt(memoryview(bytes(range(216))).cast("B", (6, 12, 3)), 3, 2)
        self.q.wait("coarse", timeout=120)
        status = self.q.status()
        self.assertEqual((status["is_quilt"], status["columns"], status["rows"]), (True, 3, 2))

    def test_a_preview_is_a_jpeg_quilt(self):
        self.need("frame.get")
        preview = self.q.preview(width=12, views=3)
        self.assertTrue(preview.startswith(b"\xff\xd8\xff"))
        self.assertEqual((preview.info["views"], preview.info["width"], preview.info["bytes"]), (3, 12, len(preview)))

    def test_the_image_is_an_array(self):
        self.need("frame.get")
        self.q.show_quilt(memoryview(bytes(range(216))).cast("B", (6, 12, 3)), 3, 2)
        self.q.wait("coarse", timeout=120)
        whole_quilt = self.q.array()
        self.assertEqual((whole_quilt.shape, whole_quilt.tobytes()), ((6, 12, 3), bytes(range(216))))
        middle = self.q.array(views=1)
        self.assertEqual(middle.shape, (3, 4, 3))
        self.assertEqual(middle[0, 0, 0], 0)  # view 3 of 6: the top left tile
        self.assertEqual(self.q.array(width=2).shape[1:], (6, 3))

    def test_a_widget_may_be_wider_than_the_views(self):
        self.need("frame.get")
        self.assertIn(f"aspect-ratio:{WIDTH}/{HEIGHT}", self.q.widget(width=10 * WIDTH)._repr_html_())


class Examples(Case):
    def run_example(self, name, *arguments, typed=""):
        path = os.pathsep.join([str(HERE.parent), *os.environ.get("PYTHONPATH", "").split(os.pathsep)])
        environment = {**os.environ, "QUILTD_SOCKET": sock, "PYTHONPATH": path}
        command = [sys.executable, str(HERE.parent / "examples" / name), *arguments]
        run = subprocess.run(command, input=typed, capture_output=True, text=True, cwd=folder, env=environment)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        return run.stdout.splitlines()

    def test_orbit(self):
        self.assertEqual(len(self.run_example("orbit.py", "120")), 3)

    def test_slider(self):
        self.assertEqual(len(self.run_example("slider.py", typed="12\n18.5\n")), 2)
        self.assertEqual(self.q.scene.get()["scene"]["camera"]["fov_y"], 18.5)

    def test_turntable(self):
        self.run_example("turntable.py", "2")
        images = [pathlib.Path(folder, f"turn_0{i}.png").read_bytes() for i in range(2)]
        self.assertEqual([png_size(image) for image in images], [(WIDTH, HEIGHT)] * 2)

    def test_slideshow(self):
        self.need("playlist.set")
        self.assertEqual(self.run_example("slideshow.py", self.q.info["folders"][0], "3600"), ["shown in turn: 1"])
        self.assertTrue(self.q.status()["playlist"]["playing"])
        self.q.playlist.stop()

    def test_numpy_volume(self):
        self.need_numpy("scene.load", "arrays")
        self.assertEqual(len(self.run_example("volume.py")), 1)

    def test_numpy_quilt(self):
        self.need_numpy("quilt.show")
        self.assertEqual(len(self.run_example("quilt.py")), 1)

    def test_numpy_mesh(self):
        self.need_numpy("scene.patch", "arrays")
        self.assertEqual(len(self.run_example("mesh.py")), 1)

    def test_numpy_explorer(self):
        self.need_numpy("scene.load", "arrays")
        self.assertEqual(len(self.run_example("explorer.py", typed="0.1\n0.3\n")), 2)

    def need_numpy(self, method, parameter=None):
        self.need(method, parameter)
        if not importlib.util.find_spec("numpy"):
            self.skipTest("there is no numpy")


if __name__ == "__main__":
    unittest.main()
