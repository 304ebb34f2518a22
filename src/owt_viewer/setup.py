from glob import glob
from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

NAME = "owt_viewer"
MANIFEST = ElementTree.parse(Path(__file__).with_name("package.xml"))

setup(
    name=NAME,
    version=MANIFEST.findtext("version"),
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/config", glob("config/*")),
    ],
    install_requires=["setuptools", "foxglove-sdk", "jaxtyping", "pydantic>=2"],
    extras_require={"test": ["beartype", "pytest", "pytest-timeout"]},
    zip_safe=False,
    maintainer="owt maintainers",
    maintainer_email="maintainers@owt.invalid",
    description="The running graph as markers: structure, stress or damage, sea surface; the viewer node.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "viewer_node = owt_viewer.node:main",
        ],
    },
)
