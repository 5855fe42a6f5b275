set(TTF_DATASET_PICTURES
    calibration.c calibration_chart.c calibration_dark.c calibration_flat.c calibration_geometry.c calibration_load.c calibration_store.c
    calibration_sum.c chart.c chart_file.c colour.c develop.c develop_figures.c develop_rows.c develop_space.c develop_strip.c
    flicker.c dng_pixels.c dng_read.c dng_write.c dots.c icc.c lossless_jpeg.c pixbuf.c pixbuf_resample.c pool.c
    tiff_client.c tiff_order.c tiff_read.c tiff_times.c tiff_unpack.c tiff_write.c)
# Loops over columns that do not depend on each other: let the compiler do several at once.
set_source_files_properties(calibration_sum.c develop_rows.c PROPERTIES COMPILE_OPTIONS -O3)
