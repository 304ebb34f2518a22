from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

NAME = "owt_campaign"
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
    install_requires=["setuptools"],
    zip_safe=False,
    maintainer="owt maintainers",
    maintainer_email="maintainers@owt.invalid",
    description="Runs cases and whole load-case tables in one process or many, without ROS.",
    license="Apache-2.0",
)
