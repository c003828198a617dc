#include "cli/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "cli/command.h"
#include "cli/field_cache.h"
#include "cli/stop.h"
#ifdef FEDER_HAS_MESHES
#include "feder/lua.h"
#endif
#ifdef FEDER_HAS_YAML
#include "feder/yaml.h"
#endif

namespace feder::cli {
namespace {

bool parse_plain(std::string_view text, double& value) {
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

// A number or a quotient of two numbers.
bool parse_number(const std::string& text, double& value) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return parse_plain(text, value);
  double below = 0;
  if (!parse_plain(std::string_view(text).substr(0, slash), value)) return false;
  if (!parse_plain(std::string_view(text).substr(slash + 1), below) || below == 0) return false;
  value /= below;
  return std::isfinite(value);
}

std::pair<std::string, std::string> split(const std::string& given, const char* option) {
  const std::size_t equals = given.find('=');
  if (equals == std::string::npos || equals == 0)
    throw Failure(kUsage, "{}: expected NAME=VALUE, got '{}'", option, given);
  return {given.substr(0, equals), given.substr(equals + 1)};
}

// World values may be quotients (dt=1/240); the script host reads plain numbers.
std::string without_quotient(const std::string& text) {
  double value = 0;
  if (text.find('/') == std::string::npos || !parse_number(text, value)) return text;
  return fmt::format("{:.17g}", value);
}

}  // namespace

void declare(Arguments& a, Options& o) {
  a.flag("--json", o.json, "print one JSON value instead of text");
  a.flag("--quiet,-q", o.quiet, "print results and errors only");
  a.text("--seed", o.seed, "seed of the world's random numbers");
  a.list("--set", o.set, "NAME=VALUE: value of a feder.param (may be repeated)");
  a.list("--world", o.world, "KEY=VALUE: dt, substeps, rigid.solver ... (may be repeated)");
  a.text("--dt", o.dt, "seconds per step, for example 1/240");
  a.whole("--threads", o.threads, 1, 64, "worker threads");
  a.text("--limit", o.limit,
         "Lua instructions per call into a script, 4 times as many in build() (default 1e8; 0: any)");
  a.text("--memory", o.memory, "bytes of Lua memory (default 1 GiB)");
  a.text("--timeout", o.timeout, "seconds of processor time; exit status 4 (default: any; test: 60 per file)");
  a.flag("--no-cache", o.no_cache, "make distance fields of meshes anew, and keep none (test never does)");
}

void hide_scene_options(Arguments& a, bool but_threads) {
  for (const char* name : {"--seed", "--set", "--world", "--dt", "--limit", "--memory", "--timeout", "--no-cache"})
    a.hide(name);
  if (!but_threads) a.hide("--threads");
}

lua::HostOptions host_options(const Options& o) {
  lua::HostOptions host;
  host.parts = o.build.parts, host.systems = o.build.systems;
  host.library_roots = library_roots();
  for (const std::string& given : o.set)
    host.set.insert_or_assign(split(given, "--set").first, split(given, "--set").second);
  for (const std::string& given : o.world) {
    const auto [key, value] = split(given, "--world");
    host.world.insert_or_assign(key, without_quotient(value));
  }
  if (!o.dt.empty()) host.world["dt"] = fmt::format("{:.17g}", read_number(o.dt, "--dt"));
  if (o.threads > 0) host.world["threads"] = std::to_string(o.threads);
  if (!o.seed.empty()) {
    const auto [end, error] = std::from_chars(o.seed.data(), o.seed.data() + o.seed.size(), host.seed);
    if (error != std::errc{} || end != o.seed.data() + o.seed.size())
      throw Failure(kUsage, "--seed: expected a whole number >= 0, got '{}'", o.seed);
    host.has_seed = true;
  }
  if (!o.limit.empty()) {
    const double limit = read_number(o.limit, "--limit");
    // a limit that is never reached keeps scripts interruptible
    host.instruction_limit = limit < 1 || limit > 1e18 ? std::uint64_t(1) << 62 : static_cast<std::uint64_t>(limit);
  }
  if (!o.memory.empty())
    host.memory_limit = static_cast<std::size_t>(std::min(read_number(o.memory, "--memory"), 1e18));
  timeout_seconds(o, 0);
  host.stop = &stop_flag();
  if (const std::string stamp = program_stamp(); !o.no_cache && !stamp.empty())
    host.make_field = [cache = FieldCache(field_cache_folder(), stamp)](const SdfDesc& d) { return cache.make(d); };
#ifdef FEDER_HAS_YAML
  host.load_yaml = yaml::push;
#endif
#ifdef FEDER_HAS_MESHES
  host.load_mesh = meshes::read;
#endif
  return host;
}

lua::HostOptions silent_host_options(const Options& o) {
  lua::HostOptions host = host_options(o);
  host.print = [](std::string_view) {};
  return host;
}

double timeout_seconds(const Options& o, double otherwise) {
  return o.timeout.empty() ? otherwise : read_number(o.timeout, "--timeout");
}

double read_number(const std::string& text, const std::string& option) {
  double value = 0;
  if (!parse_number(text, value) || value < 0)
    throw Failure(kUsage, "{}: expected a number >= 0 or a quotient such as 1/240, got '{}'", option, text);
  return value;
}

void add_options(std::vector<std::string>& words, const OptionWords& options) {
  for (const auto& [name, value] : options)
    if (!value.empty()) words.insert(words.end(), {name, value});
}

void add_scene_options(std::vector<std::string>& words, const Options& o) {
  for (const std::string& s : o.set) add_options(words, {{"--set", s}});
  for (const std::string& w : o.world) add_options(words, {{"--world", w}});
  add_options(words, {{"--dt", o.dt}, {"--threads", o.threads > 0 ? std::to_string(o.threads) : ""}});
}

std::string command_text(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& w : words)
    out += (out.empty() ? "" : " ") + (w.find(' ') == std::string::npos ? w : "'" + w + "'");
  return out;
}

std::vector<std::filesystem::path> library_roots() {
  std::error_code ignored;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  const std::filesystem::path installed = program.parent_path().parent_path() / "share/feder/scripts";
  if (!program.empty() && std::filesystem::is_directory(installed, ignored)) return {installed};
  return {FEDER_SOURCE_SCRIPTS};
}

std::filesystem::path scenes_folder() { return library_roots().front().parent_path() / "scenes"; }

}  // namespace feder::cli
