/* See pty_shim.c. */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

/* Where line settings are written down from now on; NULL: as the environment says. */
void pty_shim_log_to(const char* path);

#ifdef __cplusplus
}
#endif
