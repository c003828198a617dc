// The options of a command, declared by binding variables. Only arguments.cpp knows CLI11, which is slow to
// compile.
#pragma once
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace feder::cli {

class Arguments {
 public:
  Arguments(const std::string& command, const std::string& summary);
  ~Arguments();
  Arguments(const Arguments&) = delete;
  Arguments& operator=(const Arguments&) = delete;

  // Names are "--seconds" or "--quiet,-q"; a word without dashes is a positional argument.
  void flag(const std::string& name, bool& value, const std::string& help);
  void hidden_flag(const std::string& name, bool& value);  // not in the help
  void text(const std::string& name, std::string& value, const std::string& help);
  void whole(const std::string& name, int& value, int lowest, int highest, const std::string& help);
  void list(const std::string& name, std::vector<std::string>& value, const std::string& help);  // name may be repeated
  void require(const std::string& name);
  void hide(const std::string& name);  // taken, and not in the help

  // False when help was asked for. std::invalid_argument "what is wrong".
  bool parse(int argc, char* argv[]);
  std::string help() const;
  // Every option that help shows, in its order.
  struct Declared {
    std::string name;  // "--seconds", "-q, --quiet", "SCENE"
    std::string type;  // "", "text", "number"
    std::string help;
    bool required = false;
  };
  std::vector<Declared> declared() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder::cli
