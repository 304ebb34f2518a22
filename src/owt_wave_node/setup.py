from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

NAME = "owt_wave_node"
MANIFEST = ElementTree.parse(Path(__file__).with_name("package.xml"))

setup(
    name=NAME,
    version=MANIFEST.findtext("version"),
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    install_requires=["setuptools", "jaxtyping", "numba", "raschii", "wavespectra", "h5netcdf", "h5py"],
    extras_require={"test": ["beartype", "pytest", "pytest-timeout"]},
    zip_safe=False,
    maintainer="owt maintainers",
    maintainer_email="maintainers@owt.invalid",
    description="Sea states, first- and second-order wave kinematics and Morison loads; the wave node.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "wave_node = owt_wave_node.node:main",
        ],
    },
)
