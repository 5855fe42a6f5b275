set(TTF_SYNTH_PREPARE_SOURCES
    prepare/autocorrelation.c prepare/deflicker.c prepare/feature_size.c prepare/flatten.c
    prepare/gradient.c prepare/gradients.c prepare/levels.c prepare/nudges.c prepare/reduce.c
    prepare/registration.c prepare/stabilise.c)
if(NOT TTFBOX_SANITIZE)
    set_source_files_properties(prepare/autocorrelation.c prepare/gradient.c prepare/gradients.c
                                PROPERTIES COMPILE_OPTIONS "-O3")
endif()
