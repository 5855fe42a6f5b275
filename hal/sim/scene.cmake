# SPDX-License-Identifier: Apache-2.0
# What the simulated camera sees: the samples, the optics, the sensor.
set(TTF_SIM_SCENE
    image_model.c
    noise.c
    optics.c
    sensor_model.c
    scene.c
    scene_banana.c
    scene_blade.c
    scene_chart.c
    scene_copper.c
    scene_cracks.c
    scene_field.c
    scene_grass.c
    scene_paint.c
    scene_sites.c
    scene_snow.c)
# Pictures are long float loops: let the compiler use its vectors, with the same arithmetic.
set_source_files_properties(${TTF_SIM_SCENE} PROPERTIES COMPILE_OPTIONS "$<$<CONFIG:RelWithDebInfo,Release>:-O3>")
