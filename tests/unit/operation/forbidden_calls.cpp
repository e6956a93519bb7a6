#include "forbidden_calls.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <ctime>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HEADSTOCK_CALLS_WATCHED 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define HEADSTOCK_CALLS_WATCHED 0
#endif
#endif
#ifndef HEADSTOCK_CALLS_WATCHED
#define HEADSTOCK_CALLS_WATCHED 1
#endif

namespace headstock {
namespace {

struct CallsOfThread {
  bool watching = false;
  std::uint64_t count = 0;
  const char* last = "";
};
thread_local constinit CallsOfThread calls_of_thread;

}  // namespace

ForbiddenCalls::ForbiddenCalls() noexcept : before_(calls_of_thread.count) {
  calls_of_thread.last = "";
  calls_of_thread.watching = true;
}
ForbiddenCalls::~ForbiddenCalls() {
  calls_of_thread.watching = false;
}
std::uint64_t ForbiddenCalls::count() const noexcept {
  return calls_of_thread.count - before_;
}
const char* ForbiddenCalls::last() const noexcept {
  return calls_of_thread.last;
}
bool ForbiddenCalls::watched() noexcept {
  return HEADSTOCK_CALLS_WATCHED != 0;
}

}  // namespace headstock

#if HEADSTOCK_CALLS_WATCHED

namespace {

void count_call(const char* name) noexcept {
  headstock::CallsOfThread& calls = headstock::calls_of_thread;
  if (!calls.watching) return;
  ++calls.count;
  calls.last = name;
}

/// The C library's own, in its present version: RTLD_NEXT may find an old one.
template <typename Function>
Function of_library(std::atomic<Function>& known, const char* name) noexcept {
  Function function = known.load(std::memory_order_relaxed);
  if (function != nullptr) return function;
  void* library = dlopen("libc.so.6", RTLD_LAZY | RTLD_NOLOAD);
  function = reinterpret_cast<Function>(dlsym(library != nullptr ? library : RTLD_NEXT, name));
  if (function == nullptr) std::abort();
  known.store(function, std::memory_order_relaxed);
  return function;
}

}  // namespace

// name, result, parameters, arguments, exception specification of the C library's declaration
#define HEADSTOCK_FORBIDDEN(name, result, parameters, arguments, specification) \
  extern "C" result name parameters specification {                             \
    static constinit std::atomic<result(*) parameters> known{nullptr};          \
    count_call(#name);                                                          \
    return of_library(known, #name) arguments;                                  \
  }

using Mutex = pthread_mutex_t;
using ReadWrite = pthread_rwlock_t;
using Condition = pthread_cond_t;
using Time = timespec;

HEADSTOCK_FORBIDDEN(pthread_mutex_lock, int, (Mutex * m), (m), noexcept)
HEADSTOCK_FORBIDDEN(pthread_mutex_trylock, int, (Mutex * m), (m), noexcept)
HEADSTOCK_FORBIDDEN(pthread_mutex_timedlock, int, (Mutex * m, const Time* t), (m, t), noexcept)
HEADSTOCK_FORBIDDEN(pthread_mutex_clocklock, int, (Mutex * m, clockid_t c, const Time* t), (m, c, t),
                    noexcept)
HEADSTOCK_FORBIDDEN(pthread_rwlock_rdlock, int, (ReadWrite * l), (l), noexcept)
HEADSTOCK_FORBIDDEN(pthread_rwlock_wrlock, int, (ReadWrite * l), (l), noexcept)
HEADSTOCK_FORBIDDEN(pthread_rwlock_tryrdlock, int, (ReadWrite * l), (l), noexcept)
HEADSTOCK_FORBIDDEN(pthread_rwlock_trywrlock, int, (ReadWrite * l), (l), noexcept)
HEADSTOCK_FORBIDDEN(pthread_spin_lock, int, (pthread_spinlock_t * l), (l), noexcept)
HEADSTOCK_FORBIDDEN(pthread_cond_wait, int, (Condition * c, Mutex* m), (c, m), )
HEADSTOCK_FORBIDDEN(pthread_cond_timedwait, int, (Condition * c, Mutex* m, const Time* t), (c, m, t), )
HEADSTOCK_FORBIDDEN(pthread_cond_clockwait, int, (Condition * c, Mutex* m, clockid_t k, const Time* t),
                    (c, m, k, t), )
HEADSTOCK_FORBIDDEN(pthread_cond_signal, int, (Condition * c), (c), noexcept)
HEADSTOCK_FORBIDDEN(pthread_cond_broadcast, int, (Condition * c), (c), noexcept)
HEADSTOCK_FORBIDDEN(sem_wait, int, (sem_t * s), (s), )
HEADSTOCK_FORBIDDEN(sem_timedwait, int, (sem_t * s, const Time* t), (s, t), )
HEADSTOCK_FORBIDDEN(sem_post, int, (sem_t * s), (s), noexcept)
HEADSTOCK_FORBIDDEN(nanosleep, int, (const Time* t, Time* left), (t, left), )
HEADSTOCK_FORBIDDEN(clock_nanosleep, int, (clockid_t c, int f, const Time* t, Time* left), (c, f, t, left), )
HEADSTOCK_FORBIDDEN(usleep, int, (useconds_t t), (t), )
HEADSTOCK_FORBIDDEN(sched_yield, int, (), (), noexcept)
HEADSTOCK_FORBIDDEN(poll, int, (pollfd * fds, nfds_t n, int t), (fds, n, t), )
HEADSTOCK_FORBIDDEN(select, int, (int n, fd_set* r, fd_set* w, fd_set* e, timeval* t), (n, r, w, e, t), )
HEADSTOCK_FORBIDDEN(epoll_wait, int, (int fd, epoll_event* events, int n, int t), (fd, events, n, t), )
HEADSTOCK_FORBIDDEN(read, ssize_t, (int fd, void* to, std::size_t n), (fd, to, n), )
HEADSTOCK_FORBIDDEN(write, ssize_t, (int fd, const void* from, std::size_t n), (fd, from, n), )
HEADSTOCK_FORBIDDEN(send, ssize_t, (int fd, const void* from, std::size_t n, int f), (fd, from, n, f), )
HEADSTOCK_FORBIDDEN(recv, ssize_t, (int fd, void* to, std::size_t n, int f), (fd, to, n, f), )
HEADSTOCK_FORBIDDEN(fsync, int, (int fd), (fd), )
HEADSTOCK_FORBIDDEN(fdatasync, int, (int fd), (fd), )
HEADSTOCK_FORBIDDEN(munmap, int, (void* at, std::size_t n), (at, n), noexcept)

// std::atomic's wait and notify, and whoever goes past the functions above.
extern "C" long syscall(long number, ...) noexcept {
  static constinit std::atomic<long (*)(long, ...)> known{nullptr};
  count_call("syscall");
  va_list list;
  va_start(list, number);
  long a[6];
  for (long& each : a) each = va_arg(list, long);
  va_end(list);
  return of_library(known, "syscall")(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}

// Memory: the C library exports its own under these names, so that nothing has to be looked up.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) noexcept {
  count_call("malloc");
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
  count_call("calloc");
  return __libc_calloc(n, size);
}
void* realloc(void* memory, std::size_t size) noexcept {
  count_call("realloc");
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  count_call("aligned_alloc");
  return __libc_memalign(alignment, size);
}
void free(void* memory) noexcept {
  count_call("free");
  __libc_free(memory);
}
}

#endif
