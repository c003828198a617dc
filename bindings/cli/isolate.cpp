#include "cli/isolate.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "cli/command.h"
#include "cli/stop.h"
#include "cli/test_file.h"
#include "feder/profile.h"

extern char** environ;

namespace feder::cli {
namespace {

using report::TestResult;
using report::TestStatus;

constexpr int kPollTime = 200;  // ms between two looks at clock and signals

// A child process with a pipe from its results descriptor.
class Child {
 public:
  explicit Child(const std::vector<std::string>& words) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw Failure(kInternal, "feder test: no pipe: {}", std::strerror(errno));
    read_ = ends[0];
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, STDERR_FILENO, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, ends[1], kResultsDescriptor);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t defaults;
    sigemptyset(&defaults);
    for (const int signal : {SIGINT, SIGTERM, SIGPROF, SIGALRM}) sigaddset(&defaults, signal);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    std::vector<char*> argv;
    for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    const int error = posix_spawn(&pid_, argv[0], &files, &attributes, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    close(ends[1]);
    if (error != 0) {
      close(read_);
      throw Failure(kInternal, "feder test: cannot start {}: {}", words[0], std::strerror(error));
    }
  }
  ~Child() {
    end();
    close(read_);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  // The next line, without its end. False at the end of the pipe, and after kPollTime without one (`waiting`).
  bool next_line(std::string& line, bool& waiting) {
    waiting = false;
    for (;;) {
      const std::size_t end = buffer_.find('\n');
      if (end != std::string::npos) {
        line = buffer_.substr(0, end);
        buffer_.erase(0, end + 1);
        return true;
      }
      pollfd wanted = {read_, POLLIN, 0};
      const int ready = poll(&wanted, 1, kPollTime);
      waiting = ready == 0 || (ready < 0 && errno == EINTR);
      if (waiting) return false;
      char bytes[65536];
      const ssize_t size = read(read_, bytes, sizeof bytes);
      if (size <= 0) return false;
      buffer_.append(bytes, static_cast<std::size_t>(size));
    }
  }

  // Ends the whole group; what waitpid says. `closing`: the pipe has ended, the child is on its way out by itself.
  int end(bool closing = false) {
    if (pid_ <= 0) return status_;
    // an own end is waited for shortly; the group is still there then, so its number is nobody else's
    for (int i = 0; closing && i < 100; ++i) {
      siginfo_t info;
      info.si_pid = 0;
      if (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid != 0) break;
      usleep(10000);
    }
    kill(-pid_, SIGKILL);
    while (waitpid(pid_, &status_, 0) < 0 && errno == EINTR) {
    }
    pid_ = 0;
    return status_;
  }

 private:
  pid_t pid_ = 0;
  int read_ = -1, status_ = 0;
  std::string buffer_;
};

std::string death_text(int status) {
  if (WIFSIGNALED(status))
    return fmt::format("the process was killed by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
  return fmt::format("the process ended with status {}", WIFEXITED(status) ? WEXITSTATUS(status) : -1);
}

std::string own_program() {
  std::error_code error;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe", error).string();
  if (error) throw Failure(kInternal, "feder test: --isolate: this system does not name the running program");
  return program;
}

// Takes the results of one child, until it has ended or the command has to. `at` counts tests.
void receive(Child& child, const std::vector<std::string>& tests, std::size_t& at,
             const std::function<void(TestResult)>& done) {
  std::uint64_t start = clock_nanoseconds();
  const auto seconds = [&] { return static_cast<double>(clock_nanoseconds() - start) * 1e-9; };
  // the test that the child was at has failed
  const auto fail = [&](const std::string& message, bool exceeded) {
    if (at >= tests.size()) return;
    TestResult r;
    r.name = tests[at++];
    const TestCase test = read_case(r.name);
    r.file = test.file, r.set = test.set;
    r.status = TestStatus::failed;
    r.seconds = seconds();
    r.exceeded = exceeded;
    r.failures.push_back({.message = message});
    done(std::move(r));
  };
  std::string line;
  bool waiting = false;
  while (!stop_flag()) {
    if (child.next_line(line, waiting)) {
      const report::Json json = report::Json::parse(line, nullptr, false);
      start = clock_nanoseconds();
      if (!json.is_object() || json.contains("start") || at >= tests.size()) continue;
      done(report::read_as<TestResult>(json));
      ++at;
    } else if (!waiting) {
      const int status = child.end(true);
      return fail(death_text(status), WIFEXITED(status) && WEXITSTATUS(status) == kBudget);
    } else if (seconds() > kTestWallTime + 2 * TimeLimit::kGrace) {
      child.end();
      return fail(fmt::format("no end after {:g} s of wall time", kTestWallTime), true);
    }
  }
}

}  // namespace

void run_isolated(const std::vector<std::string>& tests, const std::vector<std::string>& arguments,
                  const std::function<void(TestResult)>& done) {
  const std::string program = own_program();
  std::size_t at = 0;
  while (at < tests.size() && !stop_flag()) {
    std::vector<std::string> words = {program, "test", "--worker"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    words.insert(words.end(), tests.begin() + static_cast<std::ptrdiff_t>(at), tests.end());
    Child child(words);
    receive(child, tests, at, done);
  }
}

int run_own_program(std::vector<std::string> words) {
  words.insert(words.begin(), own_program());
  Child child(words);
  std::string line;
  bool waiting = false;
  while (child.next_line(line, waiting) || waiting)
    if (stop_flag()) return -1;
  const int status = child.end(true);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void send_line(const report::Json& line) {
  const std::string text = line.dump(-1, ' ', false, report::Json::error_handler_t::replace) + "\n";
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = write(kResultsDescriptor, text.data() + sent, text.size() - sent);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) _exit(kFailed);  // nobody listens
    sent += static_cast<std::size_t>(n);
  }
}

}  // namespace feder::cli
