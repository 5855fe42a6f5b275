set(TTF_DATASET_TRADE
    image_file.c image_file_exif.c image_file_linear.c jpeg.c png.c
    sequence_image.c sequence_memory.c)
