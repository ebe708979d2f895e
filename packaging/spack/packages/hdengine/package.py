# SPDX-License-Identifier: GPL-3.0-or-later
from spack.package import *


class Hdengine(PythonPackage):
    """Torsional stiffness of the contact between flexspline and bearing of a harmonic drive."""

    homepage = "https://doi.org/10.3389/fmats.2023.1211019"  # the model's paper

    license("GPL-3.0-or-later")
    skip_modules = ["hdengine.figures", "hdengine.report"]  # they need py-matplotlib and py-jinja2

    # Once hdengine has an address: pypi = "hdengine/hdengine-VERSION.tar.gz", and no url below
    version(
        "@version@".replace("+", "-"),
        sha256="@sha256@",
        url="file://@folder@/hdengine-@version@.tar.gz",
    )

    depends_on("c", type="build")
    depends_on("fortran", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("ninja", type="build")
    depends_on("meson@1.2:", type="build")
    depends_on("py-meson-python@0.17:", type="build")

    depends_on("python@3.10:", type=("build", "link", "run"))
    depends_on("py-numpy@1.26:", type=("build", "run"))
    depends_on("py-tomli@2:", type="run", when="^python@:3.10")

    depends_on("mumps~mpi+double")
    depends_on("metis@5:")
    depends_on("lapack")
    depends_on("fftw@3:~mpi precision=float,double")

    def config_settings(self, spec, prefix):
        lapack = spec["lapack"].name.removeprefix("intel-oneapi-")
        return {
            "setup-args": {
                "-Dlapack": lapack if lapack in ("openblas", "flexiblas", "mkl") else "lapack",
                "-Dinclude_path": spec["mumps"].prefix.include,
                "-Dlibrary_path": spec["mumps"].prefix.lib,
            }
        }

    def test_version(self):
        """both commands start"""
        which(self.prefix.bin.join("hdengine.x"))("--version")
        which(self.prefix.bin.hdengine)("--version")
