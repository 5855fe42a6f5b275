/* SPDX-License-Identifier: Apache-2.0 */
/* map_format.h: what the writer and the reader of a map's file share. */
#ifndef TTF_SYNTH_QUILT_MAP_FORMAT_H
#define TTF_SYNTH_QUILT_MAP_FORMAT_H

#define TTF_MAP_FORMAT  "ttfbox quilt map"
#define TTF_MAP_VERSION 1

#endif
