set(TTF_DATASET_STORE
    hash.c io.c io_faulty.c io_posix.c json_writer.c)
