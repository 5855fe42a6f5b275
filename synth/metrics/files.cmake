# SPDX-License-Identifier: Apache-2.0
set(TTF_SYNTH_METRICS_SOURCES
    metrics/activity.c metrics/colour_distance.c metrics/patch_compare.c metrics/patch_nearest.c
    metrics/repetition.c metrics/seams.c metrics/sliced.c metrics/synchrony.c)
# As synth/CMakeLists.txt does: loops over pixels and patches.
if(NOT TTFBOX_SANITIZE)
    set_source_files_properties(metrics/colour_distance.c metrics/patch_compare.c
                                metrics/patch_nearest.c PROPERTIES COMPILE_OPTIONS "-O3")
endif()
