"""The smallest build backend that pip takes: one module and the program `physagent`."""

import zipfile
from pathlib import Path

CLI = """
import os, sys
def main():
    print(os.getpid(), *sys.argv[1:])
    return 7
"""
FILES = {
    "tiny.py": CLI,
    "tiny-1.dist-info/METADATA": "Metadata-Version: 2.1\nName: tiny\nVersion: 1\n",
    "tiny-1.dist-info/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    "tiny-1.dist-info/entry_points.txt": "[console_scripts]\nphysagent = tiny:main\n",
}


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """PEP 660: write the wheel, return its name."""
    name = "tiny-1-py3-none-any.whl"
    record = "".join(f"{path},,{len(text)}\n" for path, text in FILES.items())
    with zipfile.ZipFile(Path(wheel_directory) / name, "w") as wheel:
        for path, text in FILES.items():
            wheel.writestr(path, text)
        wheel.writestr("tiny-1.dist-info/RECORD", record + "tiny-1.dist-info/RECORD,,\n")
    return name
