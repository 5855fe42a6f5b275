# SPDX-License-Identifier: Apache-2.0
# Files as bytes in the program, as they lie in the source tree: when one changes, it is embedded anew.
#
#   ttf_embed(TARGET NAME FILES page/a.js page/b.css)
#
# gives TARGET's sources NAME_sources.h: struct NAME_source {name, data, bytes}, NAME_source_find("a.js") and
# NAME_source_at(0), (1), ... NULL behind the last. Names are those below the folder that STRIP names (default: no folder at all).
# All of these together are the target 'embedded', for what reads sources without building them (./dev lint).
add_custom_target(embedded)

function(ttf_embed target name)
    cmake_parse_arguments(E "" "STRIP" "FILES" ${ARGN})
    set(folder ${CMAKE_CURRENT_BINARY_DIR}/${name}_embedded)
    set(paths)
    foreach(file IN LISTS E_FILES)
        list(APPEND paths ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    endforeach()
    string(REPLACE ";" "|" joined "${paths}")
    set(strip)
    if(E_STRIP)
        set(strip ${CMAKE_CURRENT_SOURCE_DIR}/${E_STRIP})
    endif()
    add_custom_command(OUTPUT ${folder}/${name}_sources.c ${folder}/${name}_sources.h
        COMMAND ${CMAKE_COMMAND} -DNAME=${name} -DFOLDER=${folder} "-DFILES=${joined}" "-DSTRIP=${strip}"
                -P ${PROJECT_SOURCE_DIR}/cmake/EmbedFiles.cmake
        DEPENDS ${paths} ${PROJECT_SOURCE_DIR}/cmake/EmbedFiles.cmake
        COMMENT "Embedding ${name}" VERBATIM)
    target_sources(${target} PRIVATE ${folder}/${name}_sources.c ${folder}/${name}_sources.h)
    target_include_directories(${target} PRIVATE ${folder})
    add_custom_target(${name}_embedded DEPENDS ${folder}/${name}_sources.h)
    add_dependencies(embedded ${name}_embedded)
endfunction()
