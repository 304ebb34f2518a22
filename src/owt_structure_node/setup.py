from glob import glob

from setuptools import find_packages, setup

NAME = "owt_structure_node"

setup(
    name=NAME,
    version="0.1.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", glob("launch/*.py")),
        (f"share/{NAME}/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools", "jaxtyping", "numba"],
    zip_safe=False,
    maintainer="owt maintainers",
    maintainer_email="maintainers@owt.invalid",
    description="Beam elements, reduction, time integration, stresses and energies; the structure node.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "structure_node = owt_structure_node.node:main",
        ],
    },
)
