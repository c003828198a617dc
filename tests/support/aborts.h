// Runs f in a copy of the process: what the FEDER_ASSERT that it hits writes, "" when it hits none.
#pragma once
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <utility>

#include "feder/error.h"

namespace feder {

template <class F>
std::string failed_assert(F&& f) {
  int ends[2];
  if (pipe(ends) != 0) return "no pipe";
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGABRT, SIG_DFL);
    dup2(ends[1], STDERR_FILENO);
    f();
    _exit(0);
  }
  close(ends[1]);
  std::string text;
  char part[256];
  for (ssize_t n; (n = read(ends[0], part, sizeof part)) > 0;) text.append(part, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT ? text : "";
}

namespace test {

template <class F>
bool aborts(F&& f) {
  return !failed_assert(std::forward<F>(f)).empty();
}

}  // namespace test
}  // namespace feder
