/* Lets the real libserialport and libmodbus work on a pseudo-terminal, for tests only.
 *
 * A pseudo-terminal has no entry under /sys/class/tty, no modem lines, and keeps neither 7 bits
 * nor parity, and libserialport insists on all three. This file stands before libc in the test
 * program (or in a program started with LD_PRELOAD) and answers these questions for
 * pseudo-terminals; everything else goes on to libc or the kernel.
 *
 * With a log file set (SIXDIAL_PTY_LOG, or pty_shim_log_to) each change of a line is one line in
 * it: "/dev/pts/3 4800 7E2" or "/dev/pts/3 DTR on, RTS off". */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include "pty_shim.h"

enum { kDescriptors = 1024 };
static const char kClassFolder[] = "/sys/class/tty/pts/";
static const char kDriver[] = "../../devices/virtual/tty/pts";

/* What a pseudo-terminal forgets, by descriptor; valid while the same device is behind it. */
struct line {
  dev_t device;
  int modem;
  int has_format;
  tcflag_t format; /* CSIZE, PARENB, PARODD as last set */
};
static struct line lines[kDescriptors];
static pthread_mutex_t guard = PTHREAD_MUTEX_INITIALIZER;
static char log_path[PATH_MAX];

void pty_shim_log_to(const char* path) {
  pthread_mutex_lock(&guard);
  snprintf(log_path, sizeof log_path, "%s", path == NULL ? "" : path);
  pthread_mutex_unlock(&guard);
}

/* With the guard held: the line behind a descriptor, NULL if that is no pseudo-terminal. */
static struct line* line_of(int fd) {
  struct stat info;
  if (fd < 0 || fd >= kDescriptors || fstat(fd, &info) != 0) return NULL;
  const unsigned int number = major(info.st_rdev);
  if (!S_ISCHR(info.st_mode) || number < 136 || number > 143) return NULL;
  struct line* line = &lines[fd];
  if (line->device != info.st_rdev) {
    memset(line, 0, sizeof *line);
    line->device = info.st_rdev;
  }
  return line;
}

static void write_log(const struct line* line, const char* format, ...) {
  const char* path = log_path[0] != '\0' ? log_path : getenv("SIXDIAL_PTY_LOG");
  if (path == NULL || path[0] == '\0') return;
  char text[128];
  int used = snprintf(text, sizeof text, "/dev/pts/%u ", minor(line->device));
  va_list arguments;
  va_start(arguments, format);
  used += vsnprintf(text + used, sizeof text - (size_t)used - 1, format, arguments);
  va_end(arguments);
  text[used++] = '\n';
  const int fd = open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0) return;
  const ssize_t written = write(fd, text, (size_t)used);
  (void)written;
  close(fd);
}

static int modem_request(struct line* line, unsigned long request, int* lines_wanted) {
  const int ready = TIOCM_CTS | TIOCM_DSR | TIOCM_CAR;
  switch (request) {
    case TIOCMGET:
      *lines_wanted = line->modem | ready;
      return 0;
    case TIOCMSET:
      line->modem = *lines_wanted;
      break;
    case TIOCMBIS:
      line->modem |= *lines_wanted;
      break;
    default:
      line->modem &= ~*lines_wanted;
      break;
  }
  write_log(
      line, "DTR %s, RTS %s", line->modem & TIOCM_DTR ? "on" : "off",
      line->modem & TIOCM_RTS ? "on" : "off");
  return 0;
}

int ioctl(int fd, unsigned long request, ...) {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  if (request == TIOCMGET || request == TIOCMSET || request == TIOCMBIS || request == TIOCMBIC) {
    pthread_mutex_lock(&guard);
    struct line* line = line_of(fd);
    const int answer = line == NULL ? -1 : modem_request(line, request, argument);
    pthread_mutex_unlock(&guard);
    if (line != NULL) return answer;
  }
  return (int)syscall(SYS_ioctl, fd, request, argument);
}

static int baud_of(speed_t speed) {
  switch (speed) {
    case B1200: return 1200;
    case B2400: return 2400;
    case B4800: return 4800;
    case B9600: return 9600;
    case B19200: return 19200;
    case B38400: return 38400;
    case B57600: return 57600;
    case B115200: return 115200;
    default: return -1;
  }
}

int tcsetattr(int fd, int when, const struct termios* wanted) {
  static int (*next)(int, int, const struct termios*);
  if (next == NULL) *(void**)&next = dlsym(RTLD_NEXT, "tcsetattr");
  struct termios kept = *wanted;
  pthread_mutex_lock(&guard);
  struct line* line = line_of(fd);
  if (line != NULL) {
    const tcflag_t flags = wanted->c_cflag;
    line->has_format = 1;
    line->format = flags & (CSIZE | PARENB | PARODD);
    const int bits = (flags & CSIZE) == CS7 ? 7 : (flags & CSIZE) == CS8 ? 8 : 0;
    const char parity = !(flags & PARENB) ? 'N' : (flags & PARODD) ? 'O' : 'E';
    write_log(
        line, "%d %d%c%d", baud_of(cfgetospeed(wanted)), bits, parity, flags & CSTOPB ? 2 : 1);
    kept.c_cflag = (flags & ~(tcflag_t)(CSIZE | PARENB | PARODD)) | CS8;
  }
  pthread_mutex_unlock(&guard);
  return next(fd, when, &kept);
}

int tcgetattr(int fd, struct termios* found) {
  static int (*next)(int, struct termios*);
  if (next == NULL) *(void**)&next = dlsym(RTLD_NEXT, "tcgetattr");
  const int result = next(fd, found);
  if (result != 0) return result;
  pthread_mutex_lock(&guard);
  const struct line* line = line_of(fd);
  if (line != NULL && line->has_format) {
    found->c_cflag =
        (found->c_cflag & ~(tcflag_t)(CSIZE | PARENB | PARODD)) | line->format;
  }
  pthread_mutex_unlock(&guard);
  return 0;
}

/* "/sys/class/tty/pts/N" of a pseudo-terminal that is there. */
static int is_class_entry(const char* path) {
  const size_t head = sizeof kClassFolder - 1;
  if (strncmp(path, kClassFolder, head) != 0 || strchr(path + head, '/') != NULL) return 0;
  char device[64];
  struct stat info;
  snprintf(device, sizeof device, "/dev/pts/%.16s", path + head);
  return stat(device, &info) == 0;
}

int lstat(const char* restrict path, struct stat* restrict info) {
  if (is_class_entry(path)) {
    memset(info, 0, sizeof *info);
    info->st_mode = S_IFLNK | 0777;
    return 0;
  }
  return (int)syscall(SYS_newfstatat, AT_FDCWD, path, info, AT_SYMLINK_NOFOLLOW);
}

/* The name under which Debian's libserialport knows lstat. */
int __lxstat(int version, const char* path, struct stat* info) {
  (void)version;
  return lstat(path, info);
}

ssize_t readlink(const char* restrict path, char* restrict target, size_t size) {
  if (is_class_entry(path)) {
    const size_t length = sizeof kDriver - 1 < size ? sizeof kDriver - 1 : size;
    memcpy(target, kDriver, length);
    return (ssize_t)length;
  }
  return syscall(SYS_readlinkat, AT_FDCWD, path, target, size);
}
