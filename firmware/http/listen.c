/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/http/listen.h"

#include <arpa/inet.h>
#include <errno.h>
#include <net/if.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#define WAITING \
    1024 /* connections that nobody took yet: of a crowd, too; one that finds no room tries again a second later */

union address {
    struct sockaddr any;
    struct sockaddr_in v4;
    struct sockaddr_in6 v6;
    struct sockaddr_un local;
};

/* A network interface's name: it has a letter, and none of what addresses are written with. */
static bool is_interface(const char *name)
{
    bool letter = false;

    if (strlen(name) >= IFNAMSIZ)
        return false;
    for (; *name; name++) {
        const bool is_letter = (*name | 0x20) >= 'a' && (*name | 0x20) <= 'z';

        letter |= is_letter;
        if (!is_letter && !(*name >= '0' && *name <= '9') && !strchr("._-", *name))
            return false;
    }
    return letter;
}

int ttf_http_address_of(void *ctx, const char *interface, char ret[TTF_HTTP_ADDRESS_SIZE])
{
    struct ifreq request = {.ifr_addr = {.sa_family = AF_INET}};
    const struct sockaddr_in *has = (const void *)&request.ifr_addr;
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    int r;

    (void)ctx;
    if (fd < 0)
        return -errno;
    memcpy(request.ifr_name, interface, strlen(interface) + 1);
    r = ioctl(fd, SIOCGIFADDR, &request) < 0 ? -errno : 0;
    (void)close(fd);
    if (r == 0 && !inet_ntop(AF_INET, &has->sin_addr, ret, TTF_HTTP_ADDRESS_SIZE))
        r = -errno;
    return r;
}

/* Behind the colon; -EINVAL. */
static int read_port(const char *text)
{
    unsigned long port;
    char *end;

    if (*text < '0' || *text > '9')
        return -EINVAL;
    port = strtoul(text, &end, 10);
    return *end || port > 65535 ? -EINVAL : (int)port;
}

/* "1.2.3.4:80", "[::1]:80". Its length, or -EINVAL. */
static int read_address(const char *text, union address *ret, bool *ret_loopback)
{
    char host[64];
    const char *colon = strrchr(text, ':');
    size_t n = colon ? (size_t)(colon - text) : 0;
    int port = colon ? read_port(colon + 1) : -EINVAL;

    if (n == 0 || n >= sizeof host || port < 0)
        return -EINVAL;
    memcpy(host, text, n);
    host[n] = '\0';
    memset(ret, 0, sizeof *ret);
    if (n > 2 && host[0] == '[' && host[n - 1] == ']') {
        host[n - 1] = '\0';
        ret->v6.sin6_family = AF_INET6;
        ret->v6.sin6_port = htons((uint16_t)port);
        *ret_loopback = strcmp(host + 1, "::1") == 0;
        return inet_pton(AF_INET6, host + 1, &ret->v6.sin6_addr) == 1 ? (int)sizeof ret->v6
                                                                      : -EINVAL;
    }
    ret->v4.sin_family = AF_INET;
    ret->v4.sin_port = htons((uint16_t)port);
    if (inet_pton(AF_INET, host, &ret->v4.sin_addr) != 1)
        return -EINVAL;
    *ret_loopback = (ntohl(ret->v4.sin_addr.s_addr) >> 24) == 127;
    return (int)sizeof ret->v4;
}

/* "usb0:80" as "1.2.3.4:80"; any other text as it is. */
static int where(const char *text, ttf_http_address_fn *address_of, void *ctx,
                 char ret[TTF_HTTP_WHERE_SIZE])
{
    const char *colon = strrchr(text, ':');
    size_t n = colon ? (size_t)(colon - text) : 0;
    char name[IFNAMSIZ] = "", address[TTF_HTTP_ADDRESS_SIZE];
    union address numbers;
    bool loopback;
    int port, r;

    if (strlen(text) >= TTF_HTTP_WHERE_SIZE)
        return -EINVAL;
    (void)snprintf(ret, TTF_HTTP_WHERE_SIZE, "%s", text);
    if (strncmp(text, "unix:", 5) == 0)
        return text[5] ? 0 : -EINVAL;
    if (n > 0 && n < sizeof name) {
        memcpy(name, text, n);
        name[n] = '\0';
    }
    if (!colon || !is_interface(name)) {
        r = read_address(text, &numbers, &loopback);
        return r < 0 ? r : 0;
    }
    port = read_port(colon + 1);
    if (port < 0)
        return port;
    r = address_of(ctx, name, address);
    if (r == 0)
        (void)snprintf(ret, TTF_HTTP_WHERE_SIZE, "%s:%d", address, port);
    return r;
}

/* What was bound, in words; port 0 has become one. */
static void name_it(int fd, struct ttf_http_socket *socket)
{
    union address bound = {.any = {.sa_family = AF_UNSPEC}};
    socklen_t n = sizeof bound;
    char host[INET6_ADDRSTRLEN] = "";

    if (getsockname(fd, &bound.any, &n) < 0)
        return;
    if (bound.any.sa_family == AF_INET6 &&
        inet_ntop(AF_INET6, &bound.v6.sin6_addr, host, sizeof host))
        (void)snprintf(socket->name, sizeof socket->name, "[%s]:%u", host,
                       ntohs(bound.v6.sin6_port));
    else if (inet_ntop(AF_INET, &bound.v4.sin_addr, host, sizeof host))
        (void)snprintf(socket->name, sizeof socket->name, "%s:%u", host, ntohs(bound.v4.sin_port));
}

static int open_tcp(const char *text, struct ttf_http_socket *ret)
{
    union address address;
    const int on = 1;
    int n = read_address(text, &address, &ret->loopback);
    int fd;

    if (n < 0)
        return n;
    fd = socket(address.any.sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0)
        return -errno;
    (void)setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (address.any.sa_family == AF_INET6)
        (void)setsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, &on, sizeof on);
    if (bind(fd, &address.any, (socklen_t)n) < 0 || listen(fd, WAITING) < 0) {
        int r = -errno;

        (void)close(fd);
        return r;
    }
    name_it(fd, ret);
    return fd;
}

/* Is anybody there? */
static bool answers(const union address *address)
{
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    bool there = fd >= 0 && connect(fd, &address->any, sizeof address->local) == 0;

    if (fd >= 0)
        (void)close(fd);
    return there;
}

/* Of a folder that hands its group on (setgid) the group is meant to use what is in it: on a box, who carries USB. */
static mode_t mode_of(const char *path)
{
    char folder[sizeof(((struct sockaddr_un *)0)->sun_path)];
    const char *slash = strrchr(path, '/');
    struct stat st;

    (void)snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1,
                   slash ? path : ".");
    return stat(folder, &st) == 0 && st.st_mode & S_ISGID ? 0660 : 0600;
}

static int open_unix(const char *path, bool group, struct ttf_http_socket *ret)
{
    union address address = {.local = {.sun_family = AF_UNIX}};
    struct stat st;
    int fd, r = 0;

    if (*path == '\0' || strlen(path) >= sizeof address.local.sun_path)
        return -EINVAL;
    memcpy(address.local.sun_path, path, strlen(path) + 1);
    if (lstat(path, &st) == 0) {
        if (!S_ISSOCK(st.st_mode))
            return -EEXIST;
        if (answers(&address))
            return -EADDRINUSE;
        (void)unlink(path);
    }
    fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0)
        return -errno;
    /* The mode is set before anybody can connect: nobody listens yet. */
    if (bind(fd, &address.any, sizeof address.local) < 0 ||
        chmod(path, group ? mode_of(path) : 0600) < 0 || listen(fd, WAITING) < 0) {
        r = -errno;
        (void)close(fd);
        return r;
    }
    ret->loopback = true;
    (void)snprintf(ret->name, sizeof ret->name, "unix:%s", path);
    return fd;
}

static int open_it(const char *text, bool group, struct ttf_http_socket *ret)
{
    char at[TTF_HTTP_WHERE_SIZE];
    int r;

    if (strncmp(text, "unix:", 5) == 0)
        return open_unix(text + 5, group, ret);
    r = where(text, ttf_http_address_of, NULL, at);
    return r < 0 ? r : open_tcp(at, ret);
}

static int cannot(int r, const char *text, struct ttf_err *err)
{
    if (r == -EINVAL) {
        ttf_err_set(err, r, text, "is no address to listen on");
        ttf_err_hint(err, "write ADDRESS:PORT, as 127.0.0.1:8080 or [::1]:8080, INTERFACE:PORT, as "
                          "usb0:8080, or unix:PATH");
        return r;
    }
    ttf_err_set(err, r, text, "cannot be listened on: %s", strerrordesc_np(-r));
    if (r == -EADDRINUSE)
        ttf_err_hint(err, "another program listens there; port 0 takes any that is free");
    if (r == -ENODEV)
        ttf_err_hint(
            err, "there is no network interface of this name; names of machines are not looked up");
    if (r == -EADDRNOTAVAIL)
        ttf_err_hint(err, "this machine or interface has no such address, or not yet");
    return r;
}

int ttf_http_listen_where(const char *text, ttf_http_address_fn *address_of, void *ctx,
                          char ret[TTF_HTTP_WHERE_SIZE], struct ttf_err *err)
{
    char made[TTF_HTTP_WHERE_SIZE];
    int r = where(text, address_of, ctx, made);

    if (r < 0)
        return cannot(r, text, err);
    memcpy(ret, made, sizeof made);
    return 0;
}

int ttf_http_listen(const char *text, bool group, struct ttf_http_socket *ret, struct ttf_err *err)
{
    struct ttf_http_socket made = {.fd = -1};

    made.fd = open_it(text, group, &made);
    if (made.fd < 0)
        return cannot(made.fd, text, err);
    *ret = made;
    return 0;
}
