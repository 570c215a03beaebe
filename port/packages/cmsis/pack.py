#!/usr/bin/env python3
"""usage: pack.py FOLDER: writes FOLDER/Lodestar.Lodestar.<version>.pack, the CMSIS pack of this tree."""
import pathlib
import sys
import xml.etree.ElementTree as ET
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
PDSC = pathlib.Path(__file__).with_name("Lodestar.Lodestar.pdsc")


def main(folder):
    package = ET.parse(PDSC).getroot()
    names = {package.findtext("license")}
    names |= {file.get("name") for file in package.iter("file") if file.get("category") != "include"}
    version = package.find("releases/release").get("version")
    target = pathlib.Path(folder) / f"Lodestar.Lodestar.{version}.pack"
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as pack:
        pack.write(PDSC, PDSC.name)
        for name in sorted(names):
            pack.write(ROOT / name, name)
    print(f"{target}: {len(names) + 1} files")


if len(sys.argv) != 2 or not pathlib.Path(sys.argv[1]).is_dir():
    sys.exit(__doc__)
main(sys.argv[1])
