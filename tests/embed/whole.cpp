// Every module of the runtime from one target, and the YAML reader handed to a script host.
#include <feder/lua.h>
#include <feder/net.h>
#include <feder/yaml.h>

#include <cstdio>

int main() {
  feder::lua::HostOptions options;
  options.load_yaml = feder::yaml::push;
  feder::yaml::check("list.yaml", "[1, 2, 3]");
  std::printf("whole: %s\n", feder::Springs::kName);
  return 0;
}
