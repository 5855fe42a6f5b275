set(TTF_DATASET_TRADE
    export.c export_file.c export_frames.c export_pictures.c export_sheet.c export_sidecar.c
    export_staging.c export_video.c export_y4m.c
    image_file.c image_file_exif.c image_file_linear.c image_file_profile.c
    import.c import_order.c import_pictures.c import_video.c
    jpeg.c npy.c png.c
    sequence_dataset.c sequence_frames.c sequence_image.c sequence_memory.c
    thumbnail.c video_child.c)
