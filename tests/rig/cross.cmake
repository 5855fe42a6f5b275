# SPDX-License-Identifier: Apache-2.0
# arm64 against the rig's tree; PKG_CONFIG_* are set by rig.py.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_SYSROOT $ENV{TTFBOX_RIG_TREE})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
# Tests of this build run on this machine's processor by qemu-user; arm64.py says where their libraries are.
find_program(TTFBOX_QEMU_USER NAMES qemu-aarch64-static qemu-aarch64)
if(TTFBOX_QEMU_USER)
    set(CMAKE_CROSSCOMPILING_EMULATOR ${TTFBOX_QEMU_USER})
endif()
