/* SPDX-License-Identifier: Apache-2.0 */
/* adapter.hpp: what the files of the module share. */
#ifndef TTF_HAL_LIBCAMERA_ADAPTER_HPP
#define TTF_HAL_LIBCAMERA_ADAPTER_HPP

#include <memory>
#include <string>

#include <libcamera/libcamera.h>

#include "boundary.h"

namespace adapter
{

/* ---- adapter_controls.cpp: the one place where versions of libcamera differ ---- */

void read_limits(const libcamera::ControlInfoMap &map, struct lc_limits *ret);
void write_settings(const struct lc_settings &settings, const libcamera::ControlInfoMap &map,
                    libcamera::ControlList *ret);
void read_metadata(const libcamera::ControlList &metadata, struct lc_settings *ret_told,
                   int64_t *ret_sensor_ns);
std::string model_of(const libcamera::Camera &camera);

/* ---- adapter.cpp ---- */

/* Of this id; empty if there is none (any more). */
std::shared_ptr<libcamera::Camera> camera_of(const char *id);

} // namespace adapter

/* ---- adapter_camera.cpp: the table's functions on one camera ---- */

int lc_adapter_hold(void *ctx, const char *id, struct lc_handle **ret) noexcept;
void lc_adapter_let_go(struct lc_handle *handle) noexcept;
int lc_adapter_offer(struct lc_handle *handle, enum lc_role role, unsigned i,
                     struct lc_offer *ret) noexcept;
int lc_adapter_configure(struct lc_handle *handle, const struct lc_ask *ask,
                         struct lc_granted *ret) noexcept;
int lc_adapter_limits(struct lc_handle *handle, struct lc_limits *ret) noexcept;
int lc_adapter_allocate(struct lc_handle *handle, unsigned n, unsigned *ret_n) noexcept;
int lc_adapter_buffer(struct lc_handle *handle, unsigned i, const void **ret_at,
                      size_t *ret_length) noexcept;
int lc_adapter_shared(struct lc_handle *handle, unsigned i) noexcept;
int lc_adapter_start(struct lc_handle *handle, const struct lc_settings *settings) noexcept;
int lc_adapter_stop(struct lc_handle *handle) noexcept;
int lc_adapter_queue(struct lc_handle *handle, unsigned buffer,
                     const struct lc_settings *settings) noexcept;
int lc_adapter_take(struct lc_handle *handle, struct lc_done *ret) noexcept;
int lc_adapter_descriptor(struct lc_handle *handle) noexcept;

#endif
