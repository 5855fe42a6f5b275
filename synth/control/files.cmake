set(TTF_SYNTH_CONTROL_SOURCES
    control/gaussian.c control/picture.c control/rates.c
    control/rate_map.c control/rate_light.c control/rate_curve.c control/spline.c
    control/rate_heights.c)
