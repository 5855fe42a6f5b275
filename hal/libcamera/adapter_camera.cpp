/* SPDX-License-Identifier: Apache-2.0 */
/* adapter_camera.cpp: one camera that is held: its stream, its buffers, its requests. */
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <deque>
#include <mutex>
#include <vector>

#include <linux/dma-buf.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "adapter.hpp"

using libcamera::CameraConfiguration;
using libcamera::FrameBuffer;
using libcamera::Request;
using libcamera::StreamRole;

namespace
{

struct mapping {
    void *at = nullptr;
    size_t length = 0;
    int descriptor = -1; /* the buffer's own */
};

/* Caches of the processor are looked after around our reading. */
void sync_buffer(const mapping &m, uint64_t flags)
{
    struct dma_buf_sync sync = {};

    sync.flags = flags | DMA_BUF_SYNC_READ;
    (void)ioctl(m.descriptor, DMA_BUF_IOCTL_SYNC, &sync);
}

enum lc_colour colour_of(const std::optional<libcamera::ColorSpace> &space)
{
    using libcamera::ColorSpace;

    if (!space)
        return LC_COLOUR_UNKNOWN;
    if (*space == ColorSpace::Raw)
        return LC_COLOUR_RAW;
    if (space->ycbcrEncoding == ColorSpace::YcbcrEncoding::None &&
        space->range == ColorSpace::Range::Full)
        return LC_COLOUR_RGB_FULL;
    if (space->ycbcrEncoding == ColorSpace::YcbcrEncoding::Rec601 &&
        space->range == ColorSpace::Range::Limited)
        return LC_COLOUR_BT601_LIMITED;
    return LC_COLOUR_OTHER;
}

std::optional<libcamera::ColorSpace> space_of(enum lc_colour colour)
{
    switch (colour) {
    case LC_COLOUR_RAW:
        return libcamera::ColorSpace::Raw;
    case LC_COLOUR_RGB_FULL:
        return libcamera::ColorSpace::Srgb;
    case LC_COLOUR_BT601_LIMITED:
        return libcamera::ColorSpace::Smpte170m;
    default:
        return std::nullopt;
    }
}

/* NULL: a camera without such a stream. */
std::unique_ptr<CameraConfiguration> configuration_of(libcamera::Camera &camera, enum lc_role role)
{
    auto configuration =
        camera.generateConfiguration({role == LC_RAW ? StreamRole::Raw : StreamRole::StillCapture});

    if (configuration && configuration->empty())
        configuration.reset();
    return configuration;
}

} // namespace

struct lc_handle {
    std::shared_ptr<libcamera::Camera> camera;
    std::unique_ptr<CameraConfiguration> configuration;
    std::unique_ptr<libcamera::FrameBufferAllocator> allocator;
    std::vector<std::unique_ptr<Request>> requests;
    std::vector<mapping> mappings;
    bool streaming = false;
    int event = -1;

    std::mutex lock; /* of what follows */
    std::deque<struct lc_done> done;
    bool gone = false;

    /* On libcamera's thread, which has nobody to catch anything. */
    void completed(Request *request) noexcept;
    void disconnected() noexcept;
    bool is_gone();
    void tell();
    void forget();
    void free_buffers();
};

void lc_handle::tell()
{
    const uint64_t one = 1;

    (void)!write(event, &one, sizeof(one));
}

void lc_handle::forget()
{
    uint64_t count;

    (void)!read(event, &count, sizeof(count));
}

bool lc_handle::is_gone()
{
    const std::lock_guard<std::mutex> held(lock);

    return gone;
}

void lc_handle::completed(Request *request) noexcept
{
    struct lc_done d = {};
    const FrameBuffer *buffer = request->buffers().begin()->second;
    const auto &metadata = buffer->metadata();

    d.buffer = static_cast<unsigned>(request->cookie());
    if (request->status() == Request::RequestCancelled ||
        metadata.status == libcamera::FrameMetadata::FrameCancelled)
        d.status = LC_CANCELLED;
    else
        d.status = metadata.status == libcamera::FrameMetadata::FrameSuccess ? LC_GOOD : LC_BAD;
    d.sequence = metadata.sequence;
    for (const auto &plane : metadata.planes())
        d.bytes += plane.bytesused;
    d.driver_ns = static_cast<int64_t>(metadata.timestamp);
    adapter::read_metadata(request->metadata(), &d.told, &d.sensor_ns);
    sync_buffer(mappings[d.buffer], DMA_BUF_SYNC_START);
    {
        const std::lock_guard<std::mutex> held(lock);
        done.push_back(d);
    }
    tell();
}

void lc_handle::disconnected() noexcept
{
    {
        const std::lock_guard<std::mutex> held(lock);
        gone = true;
    }
    tell();
}

void lc_handle::free_buffers()
{
    requests.clear();
    for (const mapping &m : mappings)
        if (m.at)
            (void)munmap(m.at, m.length);
    mappings.clear();
    allocator.reset();
}

int lc_adapter_hold(void *, const char *id, struct lc_handle **ret) noexcept
{
    auto handle = std::make_unique<lc_handle>();

    handle->camera = adapter::camera_of(id);
    if (!handle->camera)
        return -ENODEV;
    handle->event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (handle->event < 0)
        return -errno;
    const int r = handle->camera->acquire();
    if (r < 0) {
        (void)close(handle->event);
        return r;
    }
    handle->camera->requestCompleted.connect(handle.get(), &lc_handle::completed);
    handle->camera->disconnected.connect(handle.get(), &lc_handle::disconnected);
    *ret = handle.release();
    return 0;
}

void lc_adapter_let_go(struct lc_handle *handle) noexcept
{
    (void)lc_adapter_stop(handle);
    handle->camera->requestCompleted.disconnect(handle);
    handle->camera->disconnected.disconnect(handle);
    handle->free_buffers();
    handle->configuration.reset();
    (void)handle->camera->release();
    handle->camera.reset();
    (void)close(handle->event);
    delete handle;
}

int lc_adapter_offer(struct lc_handle *handle, enum lc_role role, unsigned i,
                     struct lc_offer *ret) noexcept
{
    const auto configuration = configuration_of(*handle->camera, role);

    if (!configuration)
        return 0;
    const auto &formats = configuration->at(0).formats();
    const auto pixels = formats.pixelformats();
    *ret = {};
    if (pixels.empty() && i == 0) { /* it lists none: there is the one that it starts from */
        ret->fourcc = configuration->at(0).pixelFormat.fourcc();
        ret->modifier = configuration->at(0).pixelFormat.modifier();
        ret->width = configuration->at(0).size.width;
        ret->height = configuration->at(0).size.height;
        return 1;
    }
    if (i >= pixels.size())
        return 0;
    const libcamera::Size most = formats.range(pixels[i]).max;
    ret->fourcc = pixels[i].fourcc();
    ret->modifier = pixels[i].modifier();
    ret->width = most.width;
    ret->height = most.height;
    return 1;
}

int lc_adapter_configure(struct lc_handle *handle, const struct lc_ask *ask,
                         struct lc_granted *ret) noexcept
{
    handle->free_buffers();
    handle->configuration = configuration_of(*handle->camera, ask->role);
    if (!handle->configuration)
        return handle->is_gone() ? -ENODEV : -EINVAL;
    auto &stream = handle->configuration->at(0);
    stream.pixelFormat = libcamera::PixelFormat(ask->fourcc, ask->modifier);
    if (ask->width && ask->height)
        stream.size = libcamera::Size(ask->width, ask->height);
    stream.bufferCount = ask->buffers;
    stream.colorSpace = space_of(ask->colour);
    if (handle->configuration->validate() == CameraConfiguration::Invalid)
        return -EINVAL;
    const int r = handle->camera->configure(handle->configuration.get());
    if (r < 0)
        return r == -EACCES ? -ENODEV : r; /* its words for a camera that was unplugged */
    *ret = {};
    ret->fourcc = stream.pixelFormat.fourcc();
    ret->modifier = stream.pixelFormat.modifier();
    ret->width = stream.size.width;
    ret->height = stream.size.height;
    ret->stride = stream.stride;
    ret->bytes = stream.frameSize;
    ret->colour = colour_of(stream.colorSpace);
    (void)snprintf(ret->colour_text, sizeof(ret->colour_text), "%s",
                   libcamera::ColorSpace::toString(stream.colorSpace).c_str());
    return 0;
}

int lc_adapter_limits(struct lc_handle *handle, struct lc_limits *ret) noexcept
{
    adapter::read_limits(handle->camera->controls(), ret);
    return 0;
}

/* All planes one after another in one piece of memory. */
static int map_buffer(const FrameBuffer &buffer, mapping *ret)
{
    const auto &planes = buffer.planes();
    size_t begin, end;

    if (planes.empty())
        return -EINVAL;
    begin = end = planes[0].offset == FrameBuffer::Plane::kInvalidOffset ? 0 : planes[0].offset;
    for (const auto &plane : planes) {
        const size_t at = plane.offset == FrameBuffer::Plane::kInvalidOffset ? 0 : plane.offset;

        if (at != end || plane.fd.get() != planes[0].fd.get())
            return -ENOTSUP;
        end = at + plane.length;
    }
    if (begin != 0)
        return -ENOTSUP;
    void *at = mmap(nullptr, end, PROT_READ, MAP_SHARED, planes[0].fd.get(), 0);
    if (at == MAP_FAILED)
        return -errno;
    *ret = {at, end, planes[0].fd.get()};
    return 0;
}

int lc_adapter_allocate(struct lc_handle *handle, unsigned n, unsigned *ret_n) noexcept
{
    libcamera::Stream *stream = handle->configuration->at(0).stream();
    int r;

    (void)n; /* asked for by configure */
    handle->free_buffers();
    handle->allocator = std::make_unique<libcamera::FrameBufferAllocator>(handle->camera);
    r = handle->allocator->allocate(stream);
    if (r < 0)
        return r;
    for (const auto &buffer : handle->allocator->buffers(stream)) {
        auto request = handle->camera->createRequest(handle->requests.size());
        mapping m;

        r = request ? map_buffer(*buffer, &m) : -ENOMEM;
        if (r == 0) {
            handle->mappings.push_back(m);
            r = request->addBuffer(stream, buffer.get());
        }
        if (r < 0) {
            handle->free_buffers();
            return r;
        }
        handle->requests.push_back(std::move(request));
    }
    *ret_n = static_cast<unsigned>(handle->requests.size());
    return 0;
}

int lc_adapter_buffer(struct lc_handle *handle, unsigned i, const void **ret_at,
                      size_t *ret_length) noexcept
{
    if (i >= handle->mappings.size())
        return -EINVAL;
    *ret_at = handle->mappings[i].at;
    *ret_length = handle->mappings[i].length;
    return 0;
}

int lc_adapter_shared(struct lc_handle *handle, unsigned i) noexcept
{
    return i < handle->mappings.size() ? handle->mappings[i].descriptor : -EINVAL;
}

int lc_adapter_start(struct lc_handle *handle, const struct lc_settings *settings) noexcept
{
    libcamera::ControlList list(handle->camera->controls());

    adapter::write_settings(*settings, handle->camera->controls(), &list);
    for (auto &request : handle->requests)
        request->reuse(Request::ReuseBuffers);
    const int r = handle->camera->start(&list);
    handle->streaming = r == 0;
    return r == -EACCES ? -ENODEV : r;
}

int lc_adapter_stop(struct lc_handle *handle) noexcept
{
    const int r = handle->streaming ? handle->camera->stop() : 0;

    handle->streaming = false;
    const std::lock_guard<std::mutex> held(handle->lock);
    handle->done.clear();
    handle->forget();
    return r;
}

int lc_adapter_queue(struct lc_handle *handle, unsigned buffer,
                     const struct lc_settings *settings) noexcept
{
    if (buffer >= handle->requests.size())
        return -EINVAL;
    Request *request = handle->requests[buffer].get();
    sync_buffer(handle->mappings[buffer], DMA_BUF_SYNC_END);
    request->reuse(Request::ReuseBuffers);
    adapter::write_settings(*settings, handle->camera->controls(), &request->controls());
    const int r = handle->camera->queueRequest(request);
    return r == -EACCES ? -ENODEV : r;
}

int lc_adapter_take(struct lc_handle *handle, struct lc_done *ret) noexcept
{
    const std::lock_guard<std::mutex> held(handle->lock);

    if (handle->gone)
        return -ENODEV;
    if (handle->done.empty()) {
        handle->forget();
        return -EAGAIN;
    }
    *ret = handle->done.front();
    handle->done.pop_front();
    return 0;
}

int lc_adapter_descriptor(struct lc_handle *handle) noexcept
{
    return handle->event;
}
