set(TTF_DATASET_PICTURES
    calibration.c calibration_dark.c calibration_flat.c calibration_load.c calibration_store.c
    calibration_sum.c colour.c icc.c pixbuf.c pixbuf_resample.c pool.c
    tiff_client.c tiff_read.c tiff_times.c tiff_unpack.c tiff_write.c)
