set(TTF_DATASET_PICTURES
    colour.c icc.c pixbuf.c pixbuf_resample.c pool.c
    tiff_client.c tiff_read.c tiff_times.c tiff_unpack.c tiff_write.c)
