set(TTF_DATASET_PICTURES
    colour.c pixbuf.c pixbuf_resample.c pool.c)
