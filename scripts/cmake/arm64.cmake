# Toolchain of scripts/check/arm64.py: Debian's cross compiler, and libraries for ARM in FEDER_ARM64_LIBRARIES, where
# that script unpacks them.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES FEDER_ARM64_LIBRARIES)
set(libraries ${FEDER_ARM64_LIBRARIES}/usr/lib/aarch64-linux-gnu)
set(ENV{PKG_CONFIG_LIBDIR} ${libraries}/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${FEDER_ARM64_LIBRARIES})
list(PREPEND CMAKE_PREFIX_PATH ${FEDER_ARM64_LIBRARIES}/usr)
set(CMAKE_CXX_FLAGS_INIT "-I${FEDER_ARM64_LIBRARIES}/usr/include/aarch64-linux-gnu")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-L${libraries}")
