set(TTF_DATASET_PICTURES placeholder.c)
