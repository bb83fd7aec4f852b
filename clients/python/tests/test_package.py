"""The wheel and the sdist, and what the package promises of itself."""

import ast
import hashlib
import os
import pathlib
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile

import quiltd

CLIENT = pathlib.Path(__file__).resolve().parent.parent


class Package(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        subprocess.run([sys.executable, CLIENT / "backend.py", self.folder], check=True, stdout=subprocess.DEVNULL)
        self.wheel = self.folder / f"quiltd-{quiltd.__version__}-py3-none-any.whl"
        self.sdist = self.folder / f"quiltd-{quiltd.__version__}.tar.gz"

    def run_python(self, code, path):
        environment = {**os.environ, "PYTHONPATH": str(path)}
        command = [sys.executable, "-c", code]
        return subprocess.run(command, check=True, capture_output=True, text=True, cwd=self.folder, env=environment).stdout.strip()

    def test_the_wheel_can_be_imported(self):
        self.assertEqual(self.run_python("import quiltd; print(quiltd.__version__)", self.wheel), quiltd.__version__)

    def test_the_record_is_of_its_files(self):
        with zipfile.ZipFile(self.wheel) as wheel:
            record = wheel.read(f"quiltd-{quiltd.__version__}.dist-info/RECORD").decode().split()
            self.assertEqual(sorted(line.split(",")[0] for line in record), sorted(wheel.namelist()))
            for name, size in (line.split(",")[::2] for line in record):
                self.assertEqual(str(len(wheel.read(name))) if size else "", size)

    def test_the_same_sources_give_the_same_wheel(self):
        first = hashlib.sha256(self.wheel.read_bytes()).digest()
        subprocess.run([sys.executable, CLIENT / "backend.py", self.folder], check=True, stdout=subprocess.DEVNULL)
        self.assertEqual(hashlib.sha256(self.wheel.read_bytes()).digest(), first)

    def test_the_sdist_builds_the_same_wheel(self):
        with tarfile.open(self.sdist) as sdist:
            sdist.extractall(self.folder)
        source = self.folder / f"quiltd-{quiltd.__version__}"
        subprocess.run([sys.executable, source / "backend.py", self.folder / "again"], check=True, stdout=subprocess.DEVNULL)
        self.assertEqual((self.folder / "again" / self.wheel.name).read_bytes(), self.wheel.read_bytes())

    def test_it_needs_the_standard_library_alone(self):
        allowed = set(sys.stdlib_module_names) if hasattr(sys, "stdlib_module_names") else None
        if allowed is None:
            self.skipTest("this Python does not list its modules")
        for path in (CLIENT / "quiltd").glob("*.py"):
            for node in ast.walk(ast.parse(path.read_text("utf-8"))):
                names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                names += [node.module] if isinstance(node, ast.ImportFrom) and not node.level else []
                self.assertLessEqual({name.split(".")[0] for name in names}, allowed, path)

    def test_it_is_written_for_python_3_9(self):
        for path in CLIENT.rglob("*.py"):
            ast.parse(path.read_text("utf-8"), feature_version=(3, 9))

    def test_examples_have_about_ten_lines(self):
        for path in (CLIENT / "examples").glob("*.py"):
            lines = [line for line in path.read_text("utf-8").splitlines()[2:] if line]
            self.assertLessEqual(len(lines), 11, path)


if __name__ == "__main__":
    unittest.main()
