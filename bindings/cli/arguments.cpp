#include "cli/arguments.h"

#include <CLI/CLI.hpp>

namespace feder::cli {

struct Arguments::Impl {
  Impl(const std::string& command, const std::string& summary) : app(summary, "feder " + command) {}
  CLI::App app;
};

namespace {

// What a help text calls the value of an option, where "TEXT" says too little.
struct ValueWord {
  std::string_view option, word;
};
constexpr ValueWord kValueWords[] = {
    {"--seconds", "S"},       {"--at", "S"},          {"--dt", "S"},
    {"--timeout", "S"},       {"--fps", "N"},         {"--seed", "N"},
    {"--limit", "N"},         {"--memory", "BYTES"},  {"--set", "NAME=VALUE"},
    {"--world", "KEY=VALUE"}, {"--size", "WxH"},      {"--shard", "I/N"},
    {"--out", "PATH"},        {"--junit", "FILE"},    {"--compare", "FILE"},
    {"--record", "FILE"},     {"--csv", "FILE"},      {"--track", "NAME"},
    {"--export", "FILE"},     {"--baseline", "FILE"}, {"--markdown", "FILE"},
    {"--screenshot", "FILE"}, {"--status", "FILE"},   {"--methods", "NAMES"},
    {"--suite", "NAME"},      {"--select", "NAME"},
};

void name_value(CLI::Option& option, const std::string& name) {
  if (name[0] != '-') return;  // what stands alone is called by its name
  for (const ValueWord& row : kValueWords)
    if (name.ends_with(row.option)) option.type_name(std::string(row.word));
}

}  // namespace

Arguments::Arguments(const std::string& command, const std::string& summary)
    : impl_(std::make_unique<Impl>(command, summary)) {}
Arguments::~Arguments() = default;

void Arguments::flag(const std::string& name, bool& value, const std::string& help) {
  impl_->app.add_flag(name, value, help);
}

void Arguments::hidden_flag(const std::string& name, bool& value) { impl_->app.add_flag(name, value)->group(""); }

void Arguments::text(const std::string& name, std::string& value, const std::string& help) {
  name_value(*impl_->app.add_option(name, value, help), name);
}

void Arguments::whole(const std::string& name, int& value, int lowest, int highest, const std::string& help) {
  const std::string range = std::to_string(lowest) + ".." + std::to_string(highest);
  impl_->app.add_option(name, value, help)->type_name("N")->check(CLI::Range(lowest, highest).description(range));
}

void Arguments::list(const std::string& name, std::vector<std::string>& value, const std::string& help) {
  CLI::Option* option = impl_->app.add_option(name, value, help);
  if (name[0] == '-') option->allow_extra_args(false);  // one value each time, so that a path may follow
  name_value(*option, name);
}

void Arguments::hide(const std::string& name) { impl_->app.get_option(name)->group(""); }

void Arguments::require(const std::string& name) { impl_->app.get_option(name)->required(); }

bool Arguments::parse(int argc, char* argv[]) {
  try {
    impl_->app.parse(argc, argv);
    return true;
  } catch (const CLI::CallForHelp&) {
    return false;
  } catch (const CLI::ParseError& e) {
    throw std::invalid_argument(e.what());
  }
}

std::string Arguments::help() const { return impl_->app.help(); }

std::vector<Arguments::Declared> Arguments::declared() const {
  std::vector<Declared> all;
  for (const CLI::Option* o : impl_->app.get_options()) {
    if (o->get_group().empty()) continue;
    const bool flag = o->get_items_expected() == 0, whole = o->get_type_name().starts_with("INT");
    all.push_back({o->get_name(false, true),
                   flag    ? ""
                   : whole ? "whole number"
                           : "text",
                   o->get_description(), o->get_required()});
  }
  return all;
}

}  // namespace feder::cli
