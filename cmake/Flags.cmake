# SPDX-License-Identifier: Apache-2.0
# Compiler flags of the whole tree.
set(CMAKE_C_STANDARD 17)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS OFF)
# Of the module for libcamera alone, whose headers are C++17.
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE RelWithDebInfo)
endif()

add_compile_definitions(_GNU_SOURCE _FILE_OFFSET_BITS=64 TTFBOX_VERSION="${PROJECT_VERSION}")
add_compile_options(
    -Wall -Wextra -Wshadow -Wpointer-arith $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes>
    $<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes> -Wwrite-strings -Wformat=2 -Wvla -Wundef -Wno-unused-parameter
    # The same bits everywhere: no fused multiply-add behind our back (ARCHITECTURE.md).
    -ffp-contract=off -fno-common -fstack-protector-strong)
# No fortify under sanitizers or without optimisation: packages have it.
if(TTFBOX_PACKAGE)
    add_compile_definitions(_FORTIFY_SOURCE=2)
    add_link_options(-Wl,-z,relro,-z,now)
endif()
if(TTFBOX_WERROR)
    add_compile_options(-Werror)
endif()
if(TTFBOX_SANITIZE)
    add_compile_options(-fsanitize=${TTFBOX_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
    add_link_options(-fsanitize=${TTFBOX_SANITIZE})
endif()
if(TTFBOX_FUZZ)
    if(NOT CMAKE_C_COMPILER_ID MATCHES "Clang")
        message(FATAL_ERROR "TTFBOX_FUZZ needs clang: use the preset 'fuzz'")
    endif()
    # ASan maps larger blocks anew each time, which was most of what a dataset's opening cost.
    add_compile_definitions(TTF_SHA256_PIECE=4096u)
    # The rooms report their branches to the fuzzer, which only fuzz targets bring along.
    add_compile_options(-fsanitize=fuzzer-no-link)
    add_link_options(-fsanitize=fuzzer-no-link)
endif()
if(TTFBOX_COVERAGE)
    # Only the rooms that `./dev coverage` looks at count (cmake/Rooms.cmake); the others stay fast.
    add_link_options(--coverage)
endif()
