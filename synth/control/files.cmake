set(TTF_SYNTH_CONTROL_SOURCES
    control/gaussian.c control/picture.c control/rates.c
    control/rate_map.c control/rate_light.c control/rate_curve.c control/spline.c
    control/rate_heights.c
    control/mask.c control/fill.c
    control/shadow.c control/shadow_ground.c control/shadow_object.c control/shadow_compose.c)
