# SPDX-License-Identifier: Apache-2.0
"""Builds for arm64 against a system in a folder, warnings being errors."""
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
QEMU_USER = shutil.which("qemu-aarch64-static") or shutil.which("qemu-aarch64")


class Cross:
    """One of them: what it is made against, and where."""

    def __init__(self, tree, folder):
        self.tree, self.folder = tree, folder

    def environment(self):
        """In which cmake finds the tree's libraries and no others."""
        lib = self.tree + "/usr/lib/aarch64-linux-gnu/pkgconfig:" + self.tree + "/usr/share/pkgconfig"
        return dict(os.environ, TTFBOX_RIG_TREE=self.tree, PKG_CONFIG_SYSROOT_DIR=self.tree, PKG_CONFIG_LIBDIR=lib)

    def step(self, command):
        done = subprocess.run(command, env=self.environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        if done.returncode != 0:
            sys.stderr.write(done.stdout.decode(errors="replace")[-4000:])
            sys.exit("rig: the programs do not build for arm64 without a warning")

    def configure(self):
        """Each time, as options may have changed since; of what is the same nothing is built anew."""
        self.step(["bash", HERE + "/links.sh", self.tree])
        self.step(["cmake", "-G", "Ninja", "-S", ROOT, "-B", self.folder, "-DCMAKE_BUILD_TYPE=RelWithDebInfo", "-DTTFBOX_WERROR=ON",
                   "-DTTFBOX_LIBCAMERA=ON", "-DCMAKE_TOOLCHAIN_FILE=" + HERE + "/cross.cmake"])

    def compile(self, names=()):
        """These targets, or all."""
        self.step(["ninja", "-C", self.folder, "-j", str(os.cpu_count())] + list(names))

    def libraries(self):
        """Where emulated programs find the tree's libraries, and nothing else of the tree: else its /tmp would be theirs."""
        prefix = self.folder + "/prefix"
        os.makedirs(prefix + "/usr", exist_ok=True)
        for name in ("lib", "usr/lib"):
            if not os.path.islink(prefix + "/" + name):
                os.symlink(self.tree + "/" + name, prefix + "/" + name)
        return prefix
