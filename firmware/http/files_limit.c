/* SPDX-License-Identifier: Apache-2.0 */
#include "files_limit.h"

#include <sys/resource.h>

#define OF_CONNECTION 2u   /* itself, and the file that it is sent */
#define OTHERS        128u /* of the program around it */
#define LEAST         16u

unsigned files_limit_connections(unsigned wanted, unsigned sockets)
{
    rlim_t enough = (rlim_t)wanted * OF_CONNECTION * sockets + OTHERS;
    struct rlimit limit;

    if (getrlimit(RLIMIT_NOFILE, &limit) < 0)
        return LEAST;
    if (limit.rlim_cur < enough) {
        struct rlimit raised = {limit.rlim_max < enough ? limit.rlim_max : enough, limit.rlim_max};

        if (setrlimit(RLIMIT_NOFILE, &raised) == 0)
            limit = raised;
    }
    if (limit.rlim_cur >= enough)
        return wanted;
    if (limit.rlim_cur < OTHERS + (rlim_t)LEAST * OF_CONNECTION * sockets)
        return LEAST;
    return (unsigned)((limit.rlim_cur - OTHERS) / OF_CONNECTION / sockets);
}
