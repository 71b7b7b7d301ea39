/* A disk that fills up, fails to sync or turns read-only under a real program, for tests only:
 * preloaded (LD_PRELOAD), it stands before libc and refuses what writes at a place of a file, as
 * SQLite does; logs and sockets go on.
 *
 * SIXDIAL_DISK_FAULTS names a file of at least 8 bytes that the test has mapped too. Its first byte
 * is the order: '-' none, 'F' full (ENOSPC), 'S' syncs fail (EIO), 'R' read-only (EROFS). Bytes 4
 * to 7 count, as a number of this machine, what was refused.
 *
 * Opening a file of a folder named dead-share never ends, as on a network share that is gone. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdint.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/types.h>
#include <unistd.h>

static volatile char* page;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void map_page(void) {
  const char* path = getenv("SIXDIAL_DISK_FAULTS");
  const int fd = path == NULL ? -1 : open(path, O_RDWR | O_CLOEXEC);
  if (fd < 0) return;
  void* mapped = mmap(NULL, 8, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (mapped != MAP_FAILED) page = mapped;
  close(fd);
}

/* The error that the order wants for a write, or for a sync; 0: none. */
static int refusal(int is_sync) {
  pthread_once(&once, map_page);
  if (page == NULL) return 0;
  int error = 0;
  if (page[0] == 'S' && is_sync) error = EIO;
  if (page[0] == 'F' && !is_sync) error = ENOSPC;
  if (page[0] == 'R' && !is_sync) error = EROFS;
  if (error != 0) __atomic_add_fetch((volatile uint32_t*)(page + 4), 1, __ATOMIC_SEQ_CST);
  return error;
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
#define REFUSE(is_sync)                   \
  do {                                    \
    const int error = refusal(is_sync);   \
    if (error != 0) {                     \
      errno = error;                      \
      return -1;                          \
    }                                     \
  } while (0)

ssize_t pwrite(int fd, const void* bytes, size_t count, off_t offset) {
  REFUSE(0);
  return NEXT(pwrite)(fd, bytes, count, offset);
}

ssize_t pwrite64(int fd, const void* bytes, size_t count, off64_t offset) {
  REFUSE(0);
  return NEXT(pwrite64)(fd, bytes, count, offset);
}

int fdatasync(int fd) {
  REFUSE(1);
  return NEXT(fdatasync)(fd);
}

int fsync(int fd) {
  REFUSE(1);
  return NEXT(fsync)(fd);
}

static void hang_on_dead_share(const char* path) {
  if (strstr(path, "/dead-share/") == NULL) return;
  for (;;) pause();
}

/* The mode of a file that may be made stands last. */
#define MODE_OF(mode, flags)                    \
  mode_t mode = 0;                              \
  do {                                          \
    va_list more;                               \
    va_start(more, flags);                      \
    if (((flags) & O_CREAT) != 0) mode = va_arg(more, mode_t); \
    va_end(more);                               \
  } while (0)

int open(const char* path, int flags, ...) {
  MODE_OF(mode, flags);
  hang_on_dead_share(path);
  return NEXT(open)(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  MODE_OF(mode, flags);
  hang_on_dead_share(path);
  return NEXT(open64)(path, flags, mode);
}
