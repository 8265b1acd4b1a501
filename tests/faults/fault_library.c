/* Preloaded into a process, counts the calls that change files of one folder; at the chosen one it kills the process
 * or lets the call fail, and it can write every call with its bytes to a log. Python's and SQLite's calls both come
 * here. Armed through ctypes by kill_server.py; without `fault_arm` it does nothing.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static char folder[PATH_MAX];
static size_t folder_length; /* 0: not armed */
static long count, at;       /* the call number `at` is the chosen one; 0: none */
static int error, forever;   /* error 0: kill */
static int log_file = -1;
static time_t clock_offset;

void fault_arm(const char *in, long chosen, int error_number, int from_then_on, const char *log_path)
{
    log_file = *log_path ? (int)syscall(SYS_openat, AT_FDCWD, log_path, O_CREAT | O_WRONLY | O_APPEND, 0600) : -1;
    count = 0, at = chosen, error = error_number, forever = from_then_on;
    snprintf(folder, sizeof folder, "%s", in);
    folder_length = strlen(folder);
}

void fault_clock(long seconds) { clock_offset = seconds; }

/* one record: kind, three lengths or places, two paths, the bytes */
static void note(char kind, const char *path, const char *other, int64_t offset, const void *bytes, int64_t length)
{
    struct { char kind[8]; int64_t path, other, offset, length; } head = {{kind}, 0, 0, offset, length};
    if (log_file < 0)
        return;
    head.path = strlen(path), head.other = strlen(other);
    syscall(SYS_write, log_file, &head, sizeof head);
    syscall(SYS_write, log_file, path, head.path);
    syscall(SYS_write, log_file, other, head.other);
    if (bytes)
        syscall(SYS_write, log_file, bytes, length);
}

static int is_watched(const char *path)
{
    return folder_length && !strncmp(path, folder, folder_length) &&
           (path[folder_length] == '/' || !path[folder_length]);
}

static const char *path_of(int descriptor, char *path)
{
    char link[64];
    ssize_t length;
    if (!folder_length)
        return "";
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    length = readlink(link, path, PATH_MAX - 1);
    path[length > 0 ? length : 0] = 0;
    return path;
}

static const char *absolute(int at_folder, const char *name, char *path)
{
    char base[PATH_MAX];
    if (!folder_length || *name == '/')
        return name;
    if (at_folder == AT_FDCWD) {
        if (!getcwd(base, sizeof base))
            return name;
    } else
        path_of(at_folder, base);
    if (snprintf(path, PATH_MAX, "%s/%s", base, name) >= PATH_MAX)
        return name;
    return path;
}

/* true: the call is to fail with errno set */
static int is_struck(void)
{
    count++;
    if (!at || (forever ? count < at : count != at))
        return 0;
    if (!error)
        syscall(SYS_kill, getpid(), SIGKILL);
    errno = error;
    return 1;
}

#define REAL(name, ...) ((__typeof__(name) *)dlsym(RTLD_NEXT, #name))(__VA_ARGS__)
#define STRIKE_FD(descriptor)                                                                                          \
    char path[PATH_MAX];                                                                                               \
    int watched = is_watched(path_of(descriptor, path));                                                               \
    if (watched && is_struck())                                                                                        \
    return -1

ssize_t pwrite64(int fd, const void *bytes, size_t length, off64_t offset)
{
    STRIKE_FD(fd);
    ssize_t done = REAL(pwrite64, fd, bytes, length, offset);
    if (watched && done > 0)
        note('w', path, "", offset, bytes, done);
    return done;
}
ssize_t pwrite(int fd, const void *bytes, size_t length, off_t offset) { return pwrite64(fd, bytes, length, offset); }

ssize_t write(int fd, const void *bytes, size_t length)
{
    STRIKE_FD(fd);
    off_t offset = watched ? lseek(fd, 0, SEEK_CUR) : 0;
    ssize_t done = REAL(write, fd, bytes, length);
    if (watched && done > 0)
        note('w', path, "", offset, bytes, done);
    return done;
}

int ftruncate64(int fd, off64_t length)
{
    STRIKE_FD(fd);
    int bad = REAL(ftruncate64, fd, length);
    if (watched && !bad)
        note('t', path, "", length, NULL, 0);
    return bad;
}
int ftruncate(int fd, off_t length) { return ftruncate64(fd, length); }

int fsync(int fd)
{
    STRIKE_FD(fd);
    int bad = REAL(fsync, fd);
    if (watched && !bad)
        note('s', path, "", 0, NULL, 0);
    return bad;
}

int fdatasync(int fd)
{
    STRIKE_FD(fd);
    int bad = REAL(fdatasync, fd);
    if (watched && !bad)
        note('s', path, "", 0, NULL, 0);
    return bad;
}

#define STRIKE_NAME(at_folder, name)                                                                                   \
    char space[PATH_MAX];                                                                                              \
    const char *path = absolute(at_folder, name, space);                                                               \
    int watched = is_watched(path);                                                                                    \
    if (watched && is_struck())                                                                                        \
    return -1

int unlinkat(int at_folder, const char *name, int flags)
{
    STRIKE_NAME(at_folder, name);
    int bad = REAL(unlinkat, at_folder, name, flags);
    if (watched && !bad)
        note('u', path, "", 0, NULL, 0);
    return bad;
}
int unlink(const char *name) { return unlinkat(AT_FDCWD, name, 0); }

static int noted(char kind, int bad, const char *from, const char *to)
{
    if (!bad && is_watched(to))
        note(kind, from, to, 0, NULL, 0);
    return bad;
}

int rename(const char *from, const char *to)
{
    char other[PATH_MAX];
    STRIKE_NAME(AT_FDCWD, from);
    (void)watched;
    return noted('r', REAL(rename, from, to), path, absolute(AT_FDCWD, to, other));
}

int renameat(int from_folder, const char *from, int to_folder, const char *to)
{
    char other[PATH_MAX];
    STRIKE_NAME(from_folder, from);
    (void)watched;
    return noted('r', REAL(renameat, from_folder, from, to_folder, to), path, absolute(to_folder, to, other));
}

int linkat(int from_folder, const char *from, int to_folder, const char *to, int flags)
{
    char other[PATH_MAX];
    STRIKE_NAME(from_folder, from);
    (void)watched;
    return noted('l', REAL(linkat, from_folder, from, to_folder, to, flags), path, absolute(to_folder, to, other));
}
int link(const char *from, const char *to) { return linkat(AT_FDCWD, from, AT_FDCWD, to, 0); }

static int opened(int at_folder, const char *name, int flags, mode_t mode)
{
    char space[PATH_MAX];
    struct stat status;
    const char *path = absolute(at_folder, name, space);
    int is_new = (flags & O_CREAT) && is_watched(path) && lstat(path, &status);
    if (is_new && is_struck())
        return -1;
    int fd = (int)syscall(SYS_openat, at_folder, name, flags, mode);
    if (is_new && fd >= 0)
        note('c', path, "", 0, NULL, 0);
    else if (fd >= 0 && (flags & O_TRUNC) && is_watched(path))
        note('t', path, "", 0, NULL, 0);
    return fd;
}

static mode_t mode_of(int flags, va_list rest) { return flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0; }

#define OPEN(name, first, at_folder)                                                                                   \
    int name(first const char *path, int flags, ...)                                                                   \
    {                                                                                                                  \
        va_list rest;                                                                                                  \
        va_start(rest, flags);                                                                                         \
        mode_t mode = mode_of(flags, rest);                                                                            \
        va_end(rest);                                                                                                  \
        return opened(at_folder, path, flags, mode);                                                                   \
    }
#define NOTHING
#define A_FOLDER int at_folder,
OPEN(open, NOTHING, AT_FDCWD)
OPEN(open64, NOTHING, AT_FDCWD)
OPEN(openat, A_FOLDER, at_folder)
OPEN(openat64, A_FOLDER, at_folder)

int clock_gettime(clockid_t id, struct timespec *now)
{
    int bad = (int)syscall(SYS_clock_gettime, id, now);
    if (!bad && id == CLOCK_REALTIME)
        now->tv_sec += clock_offset;
    return bad;
}
