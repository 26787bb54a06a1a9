find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(HWY REQUIRED IMPORTED_TARGET libhwy)

# TBB first: OpenVDB's own find module shadows it and fails when it comes second.
find_package(TBB CONFIG REQUIRED)
list(APPEND CMAKE_MODULE_PATH "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB")
find_package(OpenVDB REQUIRED)
list(REMOVE_ITEM CMAKE_MODULE_PATH "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB")

# What documents and journals are made of, and their checksums and packing.
pkg_check_modules(SQLITE REQUIRED IMPORTED_TARGET sqlite3)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(DEFLATE REQUIRED IMPORTED_TARGET libdeflate)
pkg_check_modules(IGZIP REQUIRED IMPORTED_TARGET libisal)
find_package(ZLIB REQUIRED)
pkg_check_modules(SECCOMP REQUIRED IMPORTED_TARGET libseccomp)
# Checksums of plugins.
pkg_check_modules(MD REQUIRED IMPORTED_TARGET libmd)

# Compressed meshes.
find_package(draco REQUIRED)

find_package(Vulkan REQUIRED COMPONENTS glslc)
find_package(X11 REQUIRED)
find_package(glfw3 REQUIRED)
pkg_check_modules(STB REQUIRED IMPORTED_TARGET stb)

pkg_check_modules(LIBUSB REQUIRED IMPORTED_TARGET libusb-1.0)

find_package(GTest REQUIRED)
# A reader and writer of 3MF that is not ours: for tests and benchmarks. Its pkg-config file asks for libraries that it does not need.
find_library(LIB3MF_LIBRARY 3MF REQUIRED)
find_path(LIB3MF_HEADERS Model/COM/NMR_DLLInterfaces.h PATH_SUFFIXES lib3mf REQUIRED)
add_library(peer_lib3mf INTERFACE IMPORTED)
target_link_libraries(peer_lib3mf INTERFACE ${LIB3MF_LIBRARY})
target_include_directories(peer_lib3mf SYSTEM INTERFACE ${LIB3MF_HEADERS})
pkg_check_modules(UMOCKDEV REQUIRED IMPORTED_TARGET umockdev-1.0)
