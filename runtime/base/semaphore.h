// A counting semaphore whose post() never waits: not for a lock, nor for a sleeper that lost its core on its way out,
// as a condition variable may (glibc's signal waits for its earlier waiters). It sleeps at once:
// std::counting_semaphore of libstdc++ yields first, and a yield may cost a whole slice.
#pragma once
#if defined(__linux__)
#include <semaphore.h>

#include <cerrno>
#else
#include <semaphore>
#endif

namespace feder {

#if defined(__linux__)
class Semaphore {
 public:
  Semaphore() { sem_init(&own_, 0, 0); }
  ~Semaphore() { sem_destroy(&own_); }
  Semaphore(const Semaphore&) = delete;
  Semaphore& operator=(const Semaphore&) = delete;
  void post() { sem_post(&own_); }
  void wait() {
    while (sem_wait(&own_) != 0 && errno == EINTR) {
    }
  }

 private:
  sem_t own_;
};
#else
class Semaphore {
 public:
  void post() { own_.release(); }
  void wait() { own_.acquire(); }

 private:
  std::counting_semaphore<> own_{0};
};
#endif

}  // namespace feder
