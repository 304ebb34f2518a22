from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

NAME = "owt_postproc"
MANIFEST = ElementTree.parse(Path(__file__).with_name("package.xml"))

setup(
    name=NAME,
    version=MANIFEST.findtext("version"),
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "data/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    install_requires=[
        "setuptools",
        "jaxtyping",
        "mcap",
        "numba",
        "plotly",
        "pyarrow",
        "pydantic>=2",
        "rosbags",
        "scipy",
        "zstandard",
    ],
    extras_require={"test": ["beartype", "hypothesis", "pytest", "pytest-timeout"]},
    zip_safe=False,
    maintainer="owt maintainers",
    maintainer_email="maintainers@owt.invalid",
    description="Rainflow counting, damage, spectra, bags and the report; the post-processing node.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "postproc_node = owt_postproc.node:main",
        ],
    },
)
