/* SPDX-License-Identifier: Apache-2.0 */
/* files_limit.h: how many connections the files that this process may open are enough for. */
#ifndef HTTP_FILES_LIMIT_H
#define HTTP_FILES_LIMIT_H

/* Raises the process's limit of open files as far as it goes; connections that each of so many sockets may then have, 16 at least. */
unsigned files_limit_connections(unsigned wanted, unsigned sockets);

#endif
