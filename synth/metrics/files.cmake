set(TTF_SYNTH_METRICS_SOURCES metrics/activity.c metrics/repetition.c metrics/seams.c)
