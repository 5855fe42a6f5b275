/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TTF_TESTS_MODEL_DISK_PRIVATE_H
#define TTF_TESTS_MODEL_DISK_PRIVATE_H

#include "model_disk.h"

extern const struct ttf_io_ops model_disk_ops;

int model_find(const struct model_disk *disk, const char *path);
int model_name_make(struct model_disk *disk, const char *path);
int model_inode_make(struct model_disk *disk, bool is_dir);
bool model_is_in(const char *path, const char *folder);
void model_write(struct model_inode *inode, const void *buf, size_t n, size_t at);
void model_truncate(struct model_inode *inode, size_t bytes);
void model_sync(struct model_inode *inode, bool keep);
void model_sync_dir(struct model_disk *disk, const char *folder, bool keep);
void model_sync_all(struct model_disk *disk, bool keep);

#endif
