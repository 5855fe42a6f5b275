# SPDX-License-Identifier: Apache-2.0
# arm64 against the rig's tree; PKG_CONFIG_* are set by rig.py.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_SYSROOT $ENV{TTFBOX_RIG_TREE})
# The compiler has a libc of its own, which it would look at first: the tree's may be a newer one.
execute_process(COMMAND ${CMAKE_C_COMPILER} -print-file-name=include OUTPUT_VARIABLE rig_own OUTPUT_STRIP_TRAILING_WHITESPACE)
execute_process(COMMAND ${CMAKE_CXX_COMPILER} -dumpversion OUTPUT_VARIABLE rig_gcc OUTPUT_STRIP_TRAILING_WHITESPACE)
set(rig_include ${CMAKE_SYSROOT}/usr/include)
set(rig_libc "-isystem ${rig_own} -isystem ${rig_include}/aarch64-linux-gnu -isystem ${rig_include}")
set(CMAKE_C_FLAGS_INIT "-nostdinc ${rig_libc}")
set(CMAKE_CXX_FLAGS_INIT
    "-nostdinc -isystem ${rig_include}/c++/${rig_gcc} -isystem ${rig_include}/aarch64-linux-gnu/c++/${rig_gcc} ${rig_libc}")
set(rig_link "-B${CMAKE_SYSROOT}/usr/lib/aarch64-linux-gnu/")
set(CMAKE_EXE_LINKER_FLAGS_INIT ${rig_link})
set(CMAKE_SHARED_LINKER_FLAGS_INIT ${rig_link})
set(CMAKE_MODULE_LINKER_FLAGS_INIT ${rig_link})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
# Tests of this build run on this machine's processor by qemu-user; arm64.py says where their libraries are.
find_program(TTFBOX_QEMU_USER NAMES qemu-aarch64-static qemu-aarch64)
if(TTFBOX_QEMU_USER)
    set(CMAKE_CROSSCOMPILING_EMULATOR ${TTFBOX_QEMU_USER})
endif()
