# install() and the exported package: find_package(feder) gives feder::feder (all of the runtime) and feder::lua.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
