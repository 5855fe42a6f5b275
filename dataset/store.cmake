set(TTF_DATASET_STORE
    hash.c io.c io_faulty.c io_posix.c json_read.c json_writer.c lines.c lines_scan.c manifest.c
    manifest_read.c manifest_write.c reader.c record.c record_check.c record_read.c record_write.c sums.c)
