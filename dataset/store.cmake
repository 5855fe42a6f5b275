set(TTF_DATASET_STORE
    fs_errors.c growth.c hash.c io.c io_faulty.c io_hashing.c io_posix.c json_parse.c json_read.c json_writer.c jsonl.c lines.c
    lines_scan.c manifest.c manifest_read.c manifest_write.c named_files.c
    notes.c notes_read.c people_file.c reader.c record.c
    record_check.c record_head.c record_read.c record_write.c recover.c reserve.c samples.c samples_read.c seal.c sums.c verify.c
    verify_people.c verify_records.c verify_slots.c verify_sums.c walk.c writer.c writer_calibration.c writer_create.c
    writer_file.c writer_folder.c writer_learn.c writer_open.c)
