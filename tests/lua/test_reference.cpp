// The reference of options: every row that a reader has is found, says its type, and has its sentence.
#include <map>
#include <set>
#include <sstream>

#include "feder/world.h"
#include "lua/part.h"
#include "lua/reference.h"
#include "lua/yaml_scene.h"
#include "support/script.h"

using namespace feder;

namespace {

struct Found {
  std::string owner;
  OptionInfo info;
};

// Rows of tables within tables are their own owner: body.friction has friction.static.
void add(std::vector<Found>& all, const std::string& owner, const std::vector<OptionInfo>& rows) {
  for (const OptionInfo& o : rows) {
    all.push_back({o.of.empty() ? owner : o.of, o});
    add(all, o.row.name, o.inner);
  }
}

std::vector<Found> everything() {
  std::vector<Found> all;
  for (const lua::DocRow& row : lua::docs(lua::parts())) add(all, row.name, row.options);
  for (const SystemDescriptor* d : catalog())
    if (d->joins.empty()) add(all, d->name, lua::system_options(catalog(), d->name));
  for (const lua::Part* part : lua::parts())
    for (const lua::YamlList& list : part->yaml) {
      CHECK(list.maker);
      if (list.more) add(all, list.key, list.more());
    }
  add(all, "param", lua::yaml_param_rows());
  for (const EventKind& kind : lua::event_kinds(catalog())) {
    add(all, "event", lua::event_fields(kind));
    add(all, "filter", lua::event_filters(kind));
    OptionInfo itself;
    itself.row.name = kind.text(), itself.type = "event";
    all.push_back({"events", itself});
  }
  return all;
}

}  // namespace

TEST_CASE("every option has a row with a type and a sentence", "[lua][reference]") {
  const std::vector<Found> all = everything();
  CHECK(all.size() > 200);
  for (const Found& f : all) {
    CAPTURE(f.owner, f.info.row.name);
    CHECK(std::string(f.info.type) != "");
    CHECK_FALSE(lua::option_sentence(f.owner, f.info.row.name).empty());
  }
}

TEST_CASE("no sentence is about an option that nobody reads, and none is there twice", "[lua][reference]") {
  std::set<std::string> known;
  for (const Found& f : everything())
    known.insert(f.owner + "." + f.info.row.name), known.insert("*." + std::string(f.info.row.name));
  std::set<std::string> seen;
  std::istringstream lines{std::string(lua::option_texts())};
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    const std::string key = line.substr(0, line.find(' '));
    CAPTURE(key);
    CHECK(known.count(key));
    CHECK(seen.insert(key).second);
    CHECK((line.back() == '.' || line.back() == '?'));
  }
}

TEST_CASE("rows know the defaults, ranges and names that their readers use", "[lua][reference]") {
  std::map<std::string, OptionInfo> by_name;
  for (const Found& f : everything()) by_name.emplace(f.owner + "." + f.info.row.name, f.info);
  const OptionInfo& density = by_name.at("body.density");
  CHECK(std::string(density.row.unit) == "kg/m3");
  CHECK(density.fallback == "1000");
  CHECK(density.row.range.text() == "a number above 0");
  CHECK(by_name.at("body.type").choices == "static, kinematic, dynamic");
  CHECK(by_name.at("body.type").fallback == "\"dynamic\"");
  CHECK(by_name.at("cloth.tear_strain").fallback == "");
  CHECK(by_name.at("net.integrator").choices.find("rk4") != std::string::npos);
  CHECK(by_name.at("fluid.kernel").choices.find("cubic") != std::string::npos);
  CHECK(by_name.at("fluid.neighbors").fallback == "\"grid\"");
  CHECK(by_name.at("rigid.solver").choices.find("soft_step") != std::string::npos);
  CHECK(by_name.at("soft_step.contact_hertz").fallback == "74");
  CHECK(by_name.at("rk45.max_steps").row.range.whole() == "a whole number from 1 to 100000000");
}

TEST_CASE("feder.choices answers to the path of every option that has names", "[lua][reference]") {
  // names are those of the pages; ranges of numbers are no names
  std::map<std::string, std::set<std::string>> names;
  for (const lua::ReferencePage& page : lua::reference(lua::parts(), catalog()))
    for (const lua::ReferenceRow& row : page.rows)
      if (page.owner != "event" && row.type.starts_with("string") && !row.allowed.empty() &&
          !row.allowed.starts_with("a "))
        for (std::string_view name : split_choices(row.allowed)) names[page.name + "." + row.name].emplace(name);
  CHECK(names.size() >= 15);
  CHECK(names.count("joint.type"));
  CHECK(names.count("world.broad_phase"));
  for (const auto& [path, expected] : names) {
    CAPTURE(path);
    std::istringstream lines(test::output_of("for _, name in ipairs(feder.choices '" + path + "') do print(name) end"));
    std::set<std::string> got;
    for (std::string line; std::getline(lines, line);) got.insert(line);
    CHECK(got == expected);
  }
  CHECK(test::output_of("print(table.concat(feder.choices 'world.rigid.solver', ' '))") ==
        test::output_of("print(table.concat(feder.choices 'rigid.solver', ' '))"));
  CHECK(test::output_of("print(#feder.choices 'world:joint.type' > 3)") == "true\n");
  CHECK_THAT(test::error_of("feder.choices 'joint.tipe'"),
             Catch::Contains("expected an option with choices") && Catch::Contains("did you mean 'joint.type'?"));
}
