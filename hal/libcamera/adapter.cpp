/* SPDX-License-Identifier: Apache-2.0 */
/* adapter.cpp: the module's table; libcamera itself, and what it complains of. */
#include <cerrno>
#include <cstdio>
#include <mutex>
#include <ostream>
#include <streambuf>

#include <libcamera/logging.h>

#include "adapter.hpp"

namespace
{

/*
 * Takes what libcamera logs, and keeps its last complaint. Its last word before it ends the process goes where whoever looks for the
 * reason finds it: this is a process of its own.
 */
class listener : public std::streambuf
{
  public:
    std::string last()
    {
        const std::lock_guard<std::mutex> held(lock_);
        return complaint_;
    }

    void forget()
    {
        const std::lock_guard<std::mutex> held(lock_);
        complaint_.clear();
        line_.clear();
    }

  protected:
    int_type overflow(int_type c) override
    {
        const char one = traits_type::to_char_type(c);

        if (!traits_type::eq_int_type(c, traits_type::eof()))
            (void)xsputn(&one, 1);
        return traits_type::not_eof(c);
    }

    std::streamsize xsputn(const char *text, std::streamsize n) override
    {
        const std::lock_guard<std::mutex> held(lock_);

        for (std::streamsize i = 0; i < n; i++) {
            if (text[i] == '\n')
                end_line();
            else if (line_.size() < LINE_MAX_BYTES)
                line_ += text[i];
        }
        return n;
    }

  private:
    static constexpr size_t LINE_MAX_BYTES = 1000;

    /* "[0:00:01.2] [12] ERROR Category file.cpp:34 words": the words. */
    void end_line()
    {
        if (line_.find(" FATAL ") != std::string::npos)
            (void)fprintf(stderr, "libcamera: %s\n", line_.c_str());
        const size_t level = line_.find(" ERROR ");
        const size_t place = line_.find(".cpp:", level == std::string::npos ? 0 : level);
        const size_t words = line_.find(' ', place == std::string::npos ? 0 : place);

        if (level != std::string::npos && place != std::string::npos && words != std::string::npos)
            complaint_ = line_.substr(words + 1);
        line_.clear();
    }

    std::mutex lock_;
    std::string line_, complaint_;
};

/* libcamera allows one manager in a process, which here is one camera's (host.c), and ends without having been asked. */
struct library {
    std::mutex lock;
    std::unique_ptr<libcamera::CameraManager> manager;
    listener said;
    std::ostream stream{&said};
};

library &the_library()
{
    static auto *const one = new library; /* never freed: libcamera's threads may log at exit */
    return *one;
}

const char *version(void *) noexcept
{
    const char *text = libcamera::CameraManager::version().c_str();

    return *text == 'v' ? text + 1 : text;
}

int begin(void *) noexcept
{
    library &l = the_library();
    const std::lock_guard<std::mutex> held(l.lock);

    if (!l.manager) {
        l.said.forget();
        (void)libcamera::logSetStream(&l.stream);
        l.manager = std::make_unique<libcamera::CameraManager>();
        const int r = l.manager->start();
        if (r < 0) {
            l.manager.reset();
            return r;
        }
    }
    return 0;
}

void end(void *) noexcept
{
    library &l = the_library();
    const std::lock_guard<std::mutex> held(l.lock);

    if (!l.manager)
        return;
    l.manager->stop();
    l.manager.reset();
}

void complaint(void *, char *ret, size_t size) noexcept
{
    (void)snprintf(ret, size, "%s", the_library().said.last().c_str());
}

int list(void *, unsigned i, struct lc_identity *ret) noexcept
{
    library &l = the_library();
    const std::lock_guard<std::mutex> held(l.lock);

    if (!l.manager)
        return 0;
    const auto cameras = l.manager->cameras();
    if (i >= cameras.size())
        return 0;
    (void)snprintf(ret->id, sizeof(ret->id), "%s", cameras[i]->id().c_str());
    (void)snprintf(ret->model, sizeof(ret->model), "%s", adapter::model_of(*cameras[i]).c_str());
    return 1;
}

} // namespace

std::shared_ptr<libcamera::Camera> adapter::camera_of(const char *id)
{
    library &l = the_library();
    const std::lock_guard<std::mutex> held(l.lock);

    return l.manager ? l.manager->get(std::string(id)) : nullptr;
}

extern "C" const struct lc_ops ttf_libcamera_ops = {
    LC_ABI,
    version,
    begin,
    end,
    complaint,
    list,
    lc_adapter_hold,
    lc_adapter_let_go,
    lc_adapter_offer,
    lc_adapter_configure,
    lc_adapter_limits,
    lc_adapter_allocate,
    lc_adapter_buffer,
    lc_adapter_shared,
    lc_adapter_start,
    lc_adapter_stop,
    lc_adapter_queue,
    lc_adapter_take,
    lc_adapter_descriptor,
};
