#!/usr/bin/env python3
"""Builds the wheel and the sdist, without setuptools and without a network: backend.py FOLDER, or pip by PEP 517."""

import base64
import hashlib
import io
import pathlib
import re
import sys
import tarfile
import zipfile
from typing import Any, Dict, List, Optional

HERE = pathlib.Path(__file__).resolve().parent
TIME = (1980, 1, 1, 0, 0, 0)  # of each file, so that the wheel of the same sources has the same bytes


def project() -> Dict[str, str]:
    """The keys of [project]; each is one string on one line (tomllib begins with Python 3.11)."""
    text = (HERE / "pyproject.toml").read_text("utf-8").split("[project]\n")[1]
    return dict(re.findall(r'^([a-z-]+) = "(.*)"$', text, re.M))


def metadata() -> str:
    about = project()
    return (
        f"Metadata-Version: 2.1\nName: {about['name']}\nVersion: {about['version']}\nSummary: {about['description']}\n"
        f"License: {about['license']}\nRequires-Python: {about['requires-python']}\nDescription-Content-Type: text/markdown\n\n"
        + (HERE / about["readme"]).read_text("utf-8")
    )


def modules() -> List[pathlib.Path]:
    return sorted(path for path in (HERE / "quiltd").iterdir() if path.suffix == ".py" or path.name == "py.typed")


def build_wheel(folder: str, settings: Optional[Dict[str, Any]] = None, metadata_folder: Optional[str] = None) -> str:
    about = project()
    info = f"{about['name']}-{about['version']}.dist-info"
    files = {f"quiltd/{path.name}": path.read_bytes() for path in modules()}
    files[f"{info}/METADATA"] = metadata().encode()
    files[f"{info}/WHEEL"] = b"Wheel-Version: 1.0\nGenerator: quiltd\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    record = [f"{name},sha256={_digest(data)},{len(data)}" for name, data in files.items()]
    files[f"{info}/RECORD"] = "\n".join([*record, f"{info}/RECORD,,", ""]).encode()
    name = f"{about['name']}-{about['version']}-py3-none-any.whl"
    with zipfile.ZipFile(pathlib.Path(folder) / name, "w") as wheel:
        for path, data in files.items():
            member = zipfile.ZipInfo(path, TIME)
            member.compress_type = zipfile.ZIP_DEFLATED
            member.external_attr = 0o100644 << 16
            wheel.writestr(member, data)
    return name


def build_sdist(folder: str, settings: Optional[Dict[str, Any]] = None) -> str:
    about = project()
    top = f"{about['name']}-{about['version']}"
    paths = [HERE / name for name in ("README.md", "backend.py", "pyproject.toml")]
    paths += [*modules(), *sorted((HERE / "examples").glob("*.py")), *sorted((HERE / "tests").glob("*.py"))]
    files = {path.relative_to(HERE).as_posix(): path.read_bytes() for path in paths}
    files["PKG-INFO"] = metadata().encode()
    with tarfile.open(pathlib.Path(folder) / f"{top}.tar.gz", "w:gz", format=tarfile.PAX_FORMAT) as sdist:
        for path, data in files.items():
            member = tarfile.TarInfo(f"{top}/{path}")
            member.size = len(data)
            sdist.addfile(member, io.BytesIO(data))
    return f"{top}.tar.gz"


def _digest(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode().rstrip("=")


if __name__ == "__main__":
    pathlib.Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    for built in (build_wheel(sys.argv[1]), build_sdist(sys.argv[1])):
        print(f"{sys.argv[1]}/{built}")
