from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

NAME = "owt_model"
MANIFEST = ElementTree.parse(Path(__file__).with_name("package.xml"))

setup(
    name=NAME,
    version=MANIFEST.findtext("version"),
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "structures/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    install_requires=["setuptools", "jaxtyping", "pydantic>=2"],
    extras_require={"test": ["beartype", "pytest", "pytest-timeout"]},
    zip_safe=False,
    maintainer="owt maintainers",
    maintainer_email="maintainers@owt.invalid",
    description="Geometry, sections, mesh, site, configuration and the frozen data that crosses stages.",
    license="Apache-2.0",
)
