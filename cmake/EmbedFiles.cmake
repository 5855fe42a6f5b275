# SPDX-License-Identifier: Apache-2.0
# Run at build time by ttf_embed: NAME, FOLDER, FILES (apart by |), STRIP.
cmake_minimum_required(VERSION 3.25)
string(REPLACE "|" ";" FILES "${FILES}")
file(WRITE ${FOLDER}/${NAME}_sources.h "/* Made by cmake/EmbedFiles.cmake. */
#ifndef ${NAME}_SOURCES_H
#define ${NAME}_SOURCES_H
#include <stddef.h>

struct ${NAME}_source {
    const char *name;
    const unsigned char *data; /* a zero byte behind its end */
    size_t bytes;
};

const struct ${NAME}_source *${NAME}_source_find(const char *name); /* NULL: there is none */
const struct ${NAME}_source *${NAME}_source_at(size_t i);           /* NULL: behind the last */

#endif
")
set(arrays "")
set(rows "")
set(i 0)
foreach(file IN LISTS FILES)
    if(STRIP)
        file(RELATIVE_PATH called ${STRIP} ${file})
    else()
        get_filename_component(called ${file} NAME)
    endif()
    file(READ ${file} hex HEX)
    string(LENGTH "${hex}" digits)
    math(EXPR bytes "${digits} / 2")
    string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," hex "${hex}")
    string(APPEND arrays "static const unsigned char source_${i}[] = {${hex}0};\n")
    string(APPEND rows "    {\"${called}\", source_${i}, ${bytes}},\n")
    math(EXPR i "${i} + 1")
endforeach()
file(WRITE ${FOLDER}/${NAME}_sources.c "/* Made by cmake/EmbedFiles.cmake. */
#include \"${NAME}_sources.h\"

#include <string.h>

${arrays}
static const struct ${NAME}_source SOURCES[] = {
${rows}};

const struct ${NAME}_source *${NAME}_source_at(size_t i)
{
    return i < sizeof SOURCES / sizeof *SOURCES ? &SOURCES[i] : NULL;
}

const struct ${NAME}_source *${NAME}_source_find(const char *name)
{
    for (size_t i = 0; i < sizeof SOURCES / sizeof *SOURCES; i++) {
        if (strcmp(SOURCES[i].name, name) == 0)
            return &SOURCES[i];
    }
    return NULL;
}
")
