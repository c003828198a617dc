#include "cli/arguments.h"

#include <CLI/CLI.hpp>

namespace feder::cli {

struct Arguments::Impl {
  Impl(const std::string& command, const std::string& summary) : app(summary, "feder " + command) {}
  CLI::App app;
};

Arguments::Arguments(const std::string& command, const std::string& summary)
    : impl_(std::make_unique<Impl>(command, summary)) {}
Arguments::~Arguments() = default;

void Arguments::flag(const std::string& name, bool& value, const std::string& help) {
  impl_->app.add_flag(name, value, help);
}

void Arguments::hidden_flag(const std::string& name, bool& value) { impl_->app.add_flag(name, value)->group(""); }

void Arguments::text(const std::string& name, std::string& value, const std::string& help) {
  impl_->app.add_option(name, value, help);
}

void Arguments::whole(const std::string& name, int& value, int lowest, int highest, const std::string& help) {
  impl_->app.add_option(name, value, help)->check(CLI::Range(lowest, highest));
}

void Arguments::list(const std::string& name, std::vector<std::string>& value, const std::string& help) {
  CLI::Option* option = impl_->app.add_option(name, value, help);
  if (name[0] == '-') option->allow_extra_args(false);  // one value each time, so that a path may follow
}

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
