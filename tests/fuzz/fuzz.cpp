// Fuzzer over the API: runs operations.lua with one seed after another until its time is over. Built with address and
// undefined-behaviour sanitizers by the preset `fuzz`; each report, also that of a sanitizer, ends with the seed.
//   fuzz [--seconds S] [--seed N] [--count N] [--operations N] [--keep-going]
// --seconds is processor time (default 60); a seed that takes 120 s of it, for its run and its replay, is a
// failure too.
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <sstream>
#include <string>

#include "feder/lua.h"
#include "feder/record.h"

extern "C" void __sanitizer_set_death_callback(void (*callback)()) __attribute__((weak));

namespace {

unsigned long long seed = 1;
int operations = 150;

void say_seed() {
  char line[160];
  const int n =
      std::snprintf(line, sizeof line, "fuzz: seed %llu failed; again: fuzz --seed %llu --count 1 --operations %d\n",
                    seed, seed, operations);
  if (write(2, line, static_cast<std::size_t>(n)) < 0) std::abort();
}

void say_and_end(int) {
  say_seed();
  _exit(1);
}

double processor_time() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// What the script printed or died of; "" when all is well.
std::string run_seed(const std::string& text) {
  std::string output, bytes;
  feder::Recorder recorder([&bytes](std::string_view more) { bytes += more; }, {});
  feder::lua::HostOptions options;
  options.print = [&output](std::string_view more) { output += more; };
  options.memory_limit = std::size_t(256) << 20;
  options.made = [&recorder](feder::World& world) { recorder.add(world); };
  feder::lua::Script script(std::move(options));
  try {
    script.load_string(
        "local SEED, OPERATIONS = " + std::to_string(seed) + ", " + std::to_string(operations) + " " + text,
        "operations.lua");
  } catch (const feder::lua::ScriptError& e) {
    output += e.what();
  }
  recorder.finish("finished");
  return output + feder::replay_difference(std::move(bytes), feder::catalog());  // without the script
}

}  // namespace

int main(int count, char** words) {
  double seconds = 60;
  unsigned long long seeds = ~0ull;
  bool keep_going = false;
  for (int i = 1; i < count; ++i) {
    const auto is = [&](const char* name) { return std::strcmp(words[i], name) == 0; };
    if (is("--keep-going")) {
      keep_going = true;
      continue;
    }
    if (i + 1 == count) return 2;
    if (is("--seconds"))
      seconds = std::atof(words[i + 1]);
    else if (is("--seed"))
      seed = std::strtoull(words[i + 1], nullptr, 10);
    else if (is("--count"))
      seeds = std::strtoull(words[i + 1], nullptr, 10);
    else if (is("--operations"))
      operations = std::atoi(words[i + 1]);
    else
      return 2;
    ++i;
  }
  if (__sanitizer_set_death_callback) __sanitizer_set_death_callback(say_seed);
  std::signal(SIGXCPU, say_and_end);
#ifndef FEDER_SANITIZED
  for (const int s : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) std::signal(s, say_and_end);
#endif
  std::ifstream file(FEDER_FUZZ_SCRIPT);
  std::stringstream text;
  text << file.rdbuf();
  unsigned long long done = 0, failed = 0;
  for (; done < seeds && processor_time() < seconds; ++seed, ++done) {
    const rlimit limit{static_cast<rlim_t>(processor_time()) + 120, RLIM_INFINITY};
    setrlimit(RLIMIT_CPU, &limit);
    const std::string said = run_seed(text.str());
    if (said.empty()) continue;
    std::fprintf(stderr, "%s\n", said.c_str());
    say_seed();
    ++failed;
    if (!keep_going) return 1;
  }
  std::printf("fuzz: %llu seeds of %d operations, up to seed %llu, %llu failed\n", done, operations, seed - 1, failed);
  return failed ? 1 : done ? 0 : 1;
}
