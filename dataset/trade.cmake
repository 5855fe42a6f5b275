set(TTF_DATASET_TRADE
    sequence_memory.c)
